//! Fitted virtual shadow maps (Giegl, Wimmer 2007a; book, 4.4.2): the samples ask for a resolution along each axis of the light's
//! plane, and the map is split, along one axis or both, until each tile has what its samples asked for.

use super::comparison::Comparison;
use super::map;
use super::tree::{Rule, TreeFrame, TreeMap, TreeShape, tile};
use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::gpu::Timer;
use crate::gpu::structs::TreeMeasurePush;
use crate::lab::{Lab, LabError};
use ash::vk;

const PARAMETERS: [Parameter; 11] = Comparison::keys(&[
    tile("256"),
    Parameter { key: "tiles", default: "256", allowed: "1 to 2048", meaning: "most tiles" },
    Parameter {
        key: "levels",
        default: "8",
        allowed: "0 to 8",
        meaning: "splits along an axis: the virtual map has 2^levels tiles a side",
    },
    Parameter {
        key: "split",
        default: "rect",
        allowed: "rect or square",
        meaning: "whether tiles are split along the axis that asks for it, or along both",
    },
    Parameter {
        key: "density",
        default: "4",
        allowed: "0.0625 to 16",
        meaning: "texels along each axis that the box around a pixel's footprint must hold",
    },
    Parameter {
        key: "drop",
        default: "0",
        allowed: "0 to 50",
        meaning: "percent of a tile's samples whose requests may be dropped",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "fvsm",
    source: "Giegl, Wimmer 2007a; Eisemann et al. 2011, 4.4.2",
    summary: "Rectangular tiles, split until each axis has the resolution that the tile's samples ask for along it",
    parameters: &PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Fvsm::new(spec, lab)?)),
};

struct Settings {
    side: u32,
    tree: TreeShape,
    density: f32,
    /// A share.
    drop: f32,
    comparison: Comparison,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    let rule = match spec.one_of("split", "rect", &["rect", "square"])? {
        "square" => Rule::Squares,
        _ => Rule::Rectangles,
    };
    Ok(Settings {
        side: spec.u32_in("tile", 256, 32..=4096)?,
        tree: TreeShape { levels: spec.u32_in("levels", 8, 0..=8)?, tiles: spec.u32_in("tiles", 256, 1..=2048)?, rule },
        density: spec.f32_in("density", 4.0, 0.0625..=16.0)?,
        drop: spec.f32_in("drop", 0.0, 0.0..=50.0)? / 100.0,
        comparison: Comparison::of(spec)?,
    })
}

pub(crate) struct Fvsm {
    settings: Settings,
    tiles: TreeMap,
}

impl Fvsm {
    pub(crate) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let settings = settings(spec)?;
        let tiles = TreeMap::new(spec, lab, settings.side, settings.tree, settings.comparison)?;
        Ok(Self { settings, tiles })
    }

    /// Rounds of refinement. What a tile asks for, its parts do not exceed, unless requests were dropped: then an axis that was
    /// done may go on.
    fn rounds(&self) -> u32 {
        self.settings.tree.levels * if self.settings.drop > 0.0 { 2 } else { 1 }
    }

    /// Requests, then the tiles that satisfy them.
    fn refine(&self, lab: &Lab, cmd: vk::CommandBuffer, timer: &mut Timer) {
        self.tiles.request(cmd, self.settings.density);
        for round in 0..=self.rounds() {
            let push = TreeMeasurePush { round, drop: self.settings.drop, threshold: 0, start: 0 };
            self.tiles.tree.measure(cmd, push);
            if round < self.rounds() {
                self.tiles.tree.expand(cmd, round);
            }
        }
        self.tiles.serve(lab, (cmd, &mut *timer), self.rounds());
        timer.mark(cmd, "lookup");
    }

    /// What the last frame left.
    pub(crate) fn left(&self, lab: &Lab) -> Result<TreeFrame, LabError> {
        self.tiles.left(lab, self.rounds())
    }
}

impl Method for Fvsm {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        self.tiles.frame(lab, |cmd, timer| self.refine(lab, cmd, timer))
    }

    of_maps!(self, INFO.name, &self.tiles.screen, &self.tiles.map);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        self.tiles.memory()
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = map::statistics(lab, &self.tiles.map)?;
        let (regions, _) = self.tiles.tree.read(lab, self.rounds())?;
        let texels = u64::from(self.settings.side).pow(2);
        let count = |of: fn(u32, u32) -> bool| regions.iter().filter(|r| of(r.splits, r.unmet)).count() as u64;
        statistics.counters.extend([
            ("tiles", regions.len() as u64),
            ("texels", regions.len() as u64 * texels),
            ("refused", count(|splits, _| splits != 0)),
            ("beyond", count(|splits, unmet| splits == 0 && unmet != 0)),
        ]);
        Ok(statistics)
    }
}
