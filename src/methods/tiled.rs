//! Tiled shadow maps (Arvo 2004; book, 4.4.2): a fixed number of tiles, placed by recursive cuts so that what is important gets the
//! finer texels. What is important a coarse map from the light decides: jumps of depth, and nearness to the viewer.

use super::comparison::Comparison;
use super::map;
use super::tree::{Rule, TreeFrame, TreeMap, TreeShape, tile};
use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::gpu::structs::ImportancePush;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

/// Entries along a side of the table by which tiles are cut, as a power of two.
const LEVELS: u32 = 7;

const PARAMETERS: [Parameter; 8] = Comparison::keys(&[
    tile("512"),
    Parameter { key: "tiles", default: "64", allowed: "1, 2, 4, 8, 16, 32 or 64", meaning: "number of tiles" },
    Parameter {
        key: "jumps",
        default: "0.25",
        allowed: "0 to 16",
        meaning: "importance of a jump of depth of a texel's height, against 1 of any texel",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "tiled",
    source: "Arvo 2004; Eisemann et al. 2011, 4.4.2",
    summary: "A fixed number of tiles, cut so that each has the same share of what a coarse map finds important",
    parameters: &PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Tiled::new(spec, lab)?)),
};

struct Settings {
    side: u32,
    tiles: u32,
    jumps: f32,
    comparison: Comparison,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    Ok(Settings {
        side: spec.u32_in("tile", 512, 32..=4096)?,
        tiles: spec.one_of("tiles", "64", &["1", "2", "4", "8", "16", "32", "64"])?.parse().unwrap_or(64),
        jumps: spec.f32_in("jumps", 0.25, 0.0..=16.0)?,
        comparison: Comparison::of(spec)?,
    })
}

pub(crate) struct Tiled {
    settings: Settings,
    tiles: TreeMap,
    importance: Compute,
    cut: Compute,
}

impl Tiled {
    pub(crate) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let (gpu, settings) = (lab.gpu(), settings(spec)?);
        let Settings { side, tiles, comparison, .. } = settings;
        // one word for each entry: its importance
        let shape = TreeShape { levels: LEVELS, tiles, rule: Rule::Changed };
        let placed = TreeMap::new(spec, lab, side, shape, comparison)?;
        let (tree, [map]) = (&placed.tree, &placed.map);
        let (light, entries) = (map.samples(&placed.screen)[3], Binding::Storage(&tree.requests));
        let border = (map.shape().border() as f32).to_bits();
        let seen = [light, Binding::Storage(map.fits()), Binding::Sampled(map.image()), entries];
        let lists = [&tree.regions, &tree.state, &placed.layers()?.root].map(Binding::Storage);
        let (importance, cut) = (spirv!("methods/tiled_importance.comp"), spirv!("methods/tiled_cut.comp"));
        let push = size_of::<ImportancePush>();
        let constants = [1, 0, LEVELS, border];
        Ok(Self {
            importance: Compute::new(gpu, "tiled_importance", importance, &seen, &constants, push)?,
            cut: Compute::new(gpu, "tiled_cut", cut, &[&[entries], &lists[..]].concat(), &[LEVELS, tiles], 4)?,
            settings,
            tiles: placed,
        })
    }

    /// Cuts that make as many tiles.
    fn rounds(&self) -> u32 {
        self.settings.tiles.ilog2()
    }

    /// A map of everything in the first layer, the tiles that it leads to, and the map of these.
    fn refine(&self, lab: &Lab, cmd: vk::CommandBuffer, timer: &mut Timer) {
        use Access::*;
        let next = || sync::barrier(&lab.gpu().device, cmd, &[(ComputeWrite, ComputeWrite)]);
        self.tiles.place(cmd, 0);
        self.tiles.map[0].draw(lab, cmd);
        timer.mark(cmd, "coarse map");
        let near = 16.0 * lab.view().camera.near as f32;
        let groups = (1 << LEVELS) / 8;
        self.importance.dispatch(cmd, &ImportancePush { near, jumps: self.settings.jumps }, [groups, groups, 1]);
        next();
        for round in 0..self.rounds() {
            self.cut.dispatch(cmd, &round, [1 << round, 1, 1]);
            next();
        }
        self.tiles.serve(lab, (cmd, &mut *timer), self.rounds());
        timer.mark(cmd, "lookup");
    }

    /// What the last frame left; the importance of entries in place of requests.
    pub(crate) fn left(&self, lab: &Lab) -> Result<TreeFrame, LabError> {
        self.tiles.left(lab, self.rounds())
    }
}

impl Method for Tiled {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        self.tiles.frame(lab, |cmd, timer| self.refine(lab, cmd, timer))
    }

    of_maps!(self, INFO.name, &self.tiles.screen, &self.tiles.map);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        self.tiles.memory()
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        map::statistics(lab, &self.tiles.map)
    }
}
