//! Queried virtual shadow maps (Giegl, Wimmer 2007b; book, 4.4.1): tiles are drawn and looked up level by level, and split where
//! that changed the shadows. What the paper asks by occlusion queries is counted on the GPU, and nothing is read back.

use super::comparison::Comparison;
use super::map;
use super::map_sampling::sampling_by;
use super::sampling::Sampling;
use super::tree::{Rule, TreeFrame, TreeMap, TreeShape, tile};
use super::{FrameTimes, LevelStatistics, Masks, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::gpu::structs::{QvsmPush, TreeMeasurePush};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

const PARAMETERS: [Parameter; 10] = Comparison::keys(&[
    tile("512"),
    Parameter { key: "tiles", default: "64", allowed: "1 to 2048, at least 4^start", meaning: "most tiles of a level" },
    Parameter {
        key: "levels",
        default: "7",
        allowed: "0 to 8",
        meaning: "times that tiles may be split: the finest level has 2^levels of them a side",
    },
    Parameter {
        key: "threshold",
        default: "4",
        allowed: "0 to 1000000",
        meaning: "pixels of a tile whose visibility may change without a split",
    },
    Parameter {
        key: "start",
        default: "1",
        allowed: "0 to 8, at most levels",
        meaning: "the first level that is drawn; its tiles are split anyway",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "qvsm",
    source: "Giegl, Wimmer 2007b; Eisemann et al. 2011, 4.4.1",
    summary: "Tiles split as long as that changes the shadows of more than a few pixels",
    parameters: &PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Qvsm::new(spec, lab)?)),
};

struct Settings {
    side: u32,
    tree: TreeShape,
    threshold: u32,
    start: u32,
    comparison: Comparison,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    let levels = spec.u32_in("levels", 7, 0..=8)?;
    let start = spec.u32_in("start", levels.min(1), 0..=8)?;
    if start > levels {
        return Err(LabError::Usage(format!(
            "key 'start' of '{spec}' is {start}, allowed is at most levels, {levels}"
        )));
    }
    let tiles = spec.u32_in("tiles", 64, 1..=2048)?;
    let first = 1 << (2 * start);
    if tiles < first {
        return Err(LabError::Usage(format!(
            "key 'tiles' of '{spec}' is {tiles}, allowed is at least 4^start, {first}: the first level has no other to fall back on"
        )));
    }
    Ok(Settings {
        side: spec.u32_in("tile", 512, 32..=4096)?,
        tree: TreeShape { levels, tiles, rule: Rule::Changed },
        threshold: spec.u32_in("threshold", 4, 0..=1_000_000)?,
        start,
        comparison: Comparison::of(spec)?,
    })
}

pub(crate) struct Qvsm {
    settings: Settings,
    tiles: TreeMap,
    /// Visibility of the rounds so far, and the round that it is of.
    kept: Buffer,
    compare: Compute,
    size: [u32; 2],
}

impl Qvsm {
    pub(crate) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let (gpu, settings, size) = (lab.gpu(), settings(spec)?, lab.view().size);
        let tiles = TreeMap::new(spec, lab, settings.side, settings.tree, settings.comparison)?;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let kept = Buffer::storage(gpu, "visibility so far", 8 * pixels, vk::BufferUsageFlags::empty())?;
        let bindings = [
            Binding::Storage(&tiles.layers()?.picked),
            Binding::Storage(&tiles.tree.regions),
            Binding::Storage(&kept),
            Binding::StorageImage(tiles.map[0].visibility_image()),
        ];
        let compare = spirv!("methods/qvsm_compare.comp");
        let constants = [settings.tree.tiles];
        Ok(Self {
            compare: Compute::new(gpu, "qvsm_compare", compare, &bindings, &constants, size_of::<QvsmPush>())?,
            settings,
            tiles,
            kept,
            size,
        })
    }

    /// Rounds without a look at shadows, then levels that are drawn, looked up and compared.
    fn refine(&self, lab: &Lab, cmd: vk::CommandBuffer, timer: &mut Timer) {
        let Settings { tree: TreeShape { levels, .. }, threshold, start, .. } = self.settings;
        let split = |round| {
            self.tiles.tree.measure(cmd, TreeMeasurePush { round, drop: 0.0, threshold, start });
            if round < levels {
                self.tiles.tree.expand(cmd, round);
            }
        };
        self.tiles.request(cmd, 1.0);
        (0..start).for_each(split);
        for round in start..=levels {
            self.tiles.serve(lab, (cmd, &mut *timer), round);
            self.compare(lab, cmd, QvsmPush { round, start });
            timer.mark(cmd, "lookup");
            split(round);
        }
    }

    fn compare(&self, lab: &Lab, cmd: vk::CommandBuffer, push: QvsmPush) {
        use Access::{StorageImage, TransferRead};
        let (device, image) = (&lab.gpu().device, self.tiles.map[0].visibility_image());
        sync::image(device, cmd, image, TransferRead, StorageImage);
        self.compare.dispatch(cmd, &push, [self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1]);
        sync::image(device, cmd, image, StorageImage, TransferRead);
        self.tiles.tree.next(cmd);
    }

    /// What the last frame left.
    pub(crate) fn left(&self, lab: &Lab) -> Result<TreeFrame, LabError> {
        self.tiles.left(lab, self.settings.tree.levels)
    }

    /// The round that the visibility of each pixel is of.
    pub(crate) fn served(&self, lab: &Lab) -> Result<Vec<u32>, LabError> {
        let kept: Vec<f32> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.kept)?);
        let pixels = self.size[0] as usize * self.size[1] as usize;
        Ok(kept[pixels..2 * pixels].iter().map(|&round| round as u32).collect())
    }
}

impl Method for Qvsm {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        self.tiles.frame(lab, |cmd, timer| self.refine(lab, cmd, timer))
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        super::of_light(&self.tiles.map, INFO.name, light)?.visibility(lab)
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        let map = super::of_light(&self.tiles.map, INFO.name, light)?;
        let share = 1.0 - 2.0 * map.shape().border() as f32 / map.shape().side as f32;
        let shader = (spirv!("methods/qvsm_sampling.comp"), &self.tiles.layers()?.root, false);
        let kept = [Binding::Storage(&self.kept)];
        let sampling = sampling_by(lab, (&self.tiles.screen, map), shader, &kept, &[share.to_bits()])?;
        // the fit is the root's: the twin knows no rounds
        Ok(Some(Sampling { inputs: None, ..sampling }))
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(map::masks(&self.tiles.map))
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.tiles.memory();
        memory.push(("visibility so far", self.kept.size));
        memory
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = map::statistics(lab, &self.tiles.map)?;
        let Settings { tree: TreeShape { levels, .. }, start, .. } = self.settings;
        let (finest, state) = self.tiles.tree.read(lab, levels)?;
        let at = |round: u32| round as usize;
        statistics.levels = (start..=levels)
            .rev()
            .map(|round| LevelStatistics {
                level: levels - round,
                requested: state.counts[at(round)],
                resident: state.counts[at(round)],
                refused: if round > 0 { state.refused[at(round - 1)] } else { 0 },
            })
            .collect();
        let sum = |list: &[u32]| list.iter().map(|&n| u64::from(n)).sum::<u64>();
        statistics.counters.extend([
            ("tiles", sum(&state.counts[at(start)..=at(levels)])),
            ("refused", sum(&state.refused[..at(levels)])),
            ("beyond", finest.iter().filter(|region| region.unmet != 0).count() as u64),
        ]);
        Ok(statistics)
    }
}
