//! What `stats.json` and `compare.json` hold.

use super::failure::Failure;
use super::measure::{Spread, Tail, Timings};
use super::sweep::{Sweep, Swept, Variant};
use serde::{Serialize, Serializer};
use std::path::Path;
use std::rc::Rc;
use umbrage::lab::{Lab, View};
use umbrage::methods::{LevelStatistics, Sampling, SamplingError, Statistics};
use umbrage::output::write_file;
use umbrage::scene::Scene;
use umbrage::truth::{CoverageError, Metrics, Reference, TruthError, compare};

/// `stats.json`: one method on one view.
#[derive(Debug, Serialize)]
pub struct Stats<'a> {
    pub device: String,
    pub driver: String,
    pub scene: SceneCounts<'a>,
    pub view: &'a View,
    pub method: &'a str,
    pub frames: u32,
    pub prepass_ms: Spread,
    pub ms: Spread,
    pub wall_ms: Spread,
    pub cold_ms: f64,
    pub stages: Named<Spread>,
    pub pages: Pages,
    pub bytes: Bytes,
    pub effective_resolution: f64,
    pub counters: Named<u64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sampling: Vec<SamplingErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<LightErrors>,
}

impl<'a> Stats<'a> {
    /// Gathers what there is to say about a method's frames.
    pub fn new(
        lab: &'a Lab,
        method: &'a str,
        timings: &Timings,
        memory: Vec<(&'static str, u64)>,
        statistics: Statistics,
    ) -> Self {
        Self {
            device: lab.device_name(),
            driver: lab.driver(),
            scene: SceneCounts::of(lab.scene()),
            view: lab.view(),
            method,
            frames: timings.count(),
            prepass_ms: timings.spread(|f| f.prepass_ms),
            ms: timings.spread(|f| f.ms),
            wall_ms: timings.spread(|f| f.wall_ms),
            cold_ms: timings.cold.ms,
            stages: Named(timings.stages()),
            pages: Pages::of(&statistics.levels),
            bytes: Bytes { total: total(&memory), by_purpose: Named(memory) },
            effective_resolution: statistics.effective_resolution,
            counters: Named(statistics.counters),
            sampling: Vec::new(),
            truth: None,
        }
    }
}

/// `compare.json`: several methods on one view.
#[derive(Debug, Serialize)]
pub struct Comparison<'a> {
    pub device: String,
    pub driver: String,
    pub scene: &'a str,
    pub view: &'a View,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<&'a Sweep>,
    pub rows: Vec<Row<'a>>,
}

/// One method of a comparison.
#[derive(Debug, Serialize)]
pub struct Row<'a> {
    pub method: &'a str,
    #[serde(flatten)]
    pub swept: Option<&'a Swept>,
    pub ms: Spread,
    /// Median over the first row's median.
    pub ratio: f64,
    pub bytes: u64,
    #[serde(flatten)]
    pub errors: LightErrors,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "coverage")]
    pub coverage: Option<CoverageError>,
    pub prepass_ms: f64,
    pub cold_ms: f64,
    pub wall_ms: f64,
    pub stages: Named<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sampling: Vec<SamplingErrors>,
}

impl<'a> Row<'a> {
    /// A row whose ratio is still to come.
    pub fn new(variant: &'a Variant, timings: &Timings, memory: &[(&'static str, u64)], errors: LightErrors) -> Self {
        Self {
            method: &variant.spec.text,
            swept: variant.swept.as_ref(),
            ms: timings.spread(|f| f.ms),
            ratio: 1.0,
            bytes: total(memory),
            errors,
            coverage: None,
            prepass_ms: timings.spread(|f| f.prepass_ms).median,
            cold_ms: timings.cold.ms,
            wall_ms: timings.spread(|f| f.wall_ms).median,
            stages: Named(timings.stages().into_iter().map(|(name, spread)| (name, spread.median)).collect()),
            sampling: Vec::new(),
        }
    }
}

/// Distances from the ray-traced shares of samples, in percent.
fn coverage<S: Serializer>(error: &Option<CoverageError>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Shares {
        mean: f64,
        edge: f64,
        worst: f64,
        edge_pixels: u64,
    }
    let shares = |&CoverageError { mean, edge, worst, edge_pixels, .. }: &_| Shares { mean, edge, worst, edge_pixels };
    error.as_ref().map(shares).serialize(serializer)
}

fn total(memory: &[(&'static str, u64)]) -> u64 {
    memory.iter().map(|(_, bytes)| bytes).sum()
}

/// Errors against the reference in percent; an `edge_error` without edges is infinite, in JSON null.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Errors {
    pub mismatch: f64,
    pub edge_error: f64,
    pub off_edge: f64,
    pub acne: f64,
    pub leak: f64,
    pub lost: f64,
    pub decided_pixels: u64,
    pub edge_pixels: u64,
}

impl From<Metrics> for Errors {
    fn from(m: Metrics) -> Self {
        Self {
            mismatch: m.mismatch,
            edge_error: m.edge_error,
            off_edge: m.off_edge,
            acne: m.acne,
            leak: m.leak,
            lost: m.lost,
            decided_pixels: m.decided_pixels,
            edge_pixels: m.edge_pixels,
        }
    }
}

/// Errors over all lights of a view together, and of each in the view's order.
#[derive(Debug, Clone, Serialize)]
pub struct LightErrors {
    #[serde(flatten)]
    pub all: Errors,
    pub lights: Vec<Errors>,
}

impl LightErrors {
    /// Compares the images of all lights with their references.
    pub fn of(visibility: &[Vec<f32>], references: &[Rc<Reference>]) -> Result<Self, TruthError> {
        let pairs = visibility.iter().zip(references);
        let each = pairs.map(|(image, reference)| compare(image, reference)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            all: each.iter().copied().sum::<Metrics>().into(),
            lights: each.into_iter().map(Errors::from).collect(),
        })
    }
}

/// Sampling errors of one light's map over the image: sides of texels in pixels.
#[derive(Debug, Clone, Serialize)]
pub struct SamplingErrors {
    /// Share of samples with a side above 1, in percent.
    pub undersampled: f64,
    pub storage_factor: f64,
    pub s: Tail,
    pub t: Tail,
    pub perspective_s: Tail,
    pub perspective_t: Tail,
}

impl SamplingErrors {
    /// Of what a method told.
    pub fn of(sampling: &Sampling) -> Self {
        let tail = |value: fn(&SamplingError) -> f32| Tail::of(sampling.samples().map(|e| f64::from(value(e))));
        Self {
            undersampled: sampling.undersampled(),
            storage_factor: sampling.storage_factor(),
            s: tail(|e| e.s),
            t: tail(|e| e.t),
            perspective_s: tail(|e| e.perspective_s),
            perspective_t: tail(|e| e.perspective_t),
        }
    }
}

/// What the scene consists of.
#[derive(Debug, Serialize)]
pub struct SceneCounts<'a> {
    name: &'a str,
    unique_triangles: u64,
    drawn_triangles: u64,
    meshes: usize,
    instances: usize,
    clusters: usize,
    materials: usize,
    texels: usize,
    bounds_min: [f64; 3],
    bounds_max: [f64; 3],
    origin: [f64; 3],
    warnings: &'a [String],
}

impl<'a> SceneCounts<'a> {
    fn of(scene: &'a Scene) -> Self {
        Self {
            name: &scene.name,
            unique_triangles: scene.unique_triangles(),
            drawn_triangles: scene.drawn_triangles(),
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            clusters: scene.clusters.len(),
            materials: scene.materials.len(),
            texels: scene.texels.len(),
            bounds_min: scene.bounds_min.to_array(),
            bounds_max: scene.bounds_max.to_array(),
            origin: scene.origin.to_array(),
            warnings: &scene.warnings,
        }
    }
}

/// Device memory.
#[derive(Debug, Serialize)]
pub struct Bytes {
    pub total: u64,
    by_purpose: Named<u64>,
}

/// Pages of all levels and of each.
#[derive(Debug, Serialize)]
pub struct Pages {
    #[serde(flatten)]
    total: PageCounts,
    levels: Vec<Level>,
}

#[derive(Debug, Serialize)]
struct Level {
    level: u32,
    #[serde(flatten)]
    pages: PageCounts,
}

#[derive(Debug, Serialize)]
struct PageCounts {
    requested: u32,
    resident: u32,
    refused: u32,
}

impl Pages {
    fn of(levels: &[LevelStatistics]) -> Self {
        let sum = |count: fn(&LevelStatistics) -> u32| levels.iter().map(count).sum();
        let counts =
            |l: &LevelStatistics| PageCounts { requested: l.requested, resident: l.resident, refused: l.refused };
        Self {
            total: PageCounts {
                requested: sum(|l| l.requested),
                resident: sum(|l| l.resident),
                refused: sum(|l| l.refused),
            },
            levels: levels.iter().map(|l| Level { level: l.level, pages: counts(l) }).collect(),
        }
    }
}

/// Named values as a JSON object that keeps their order.
#[derive(Debug)]
pub struct Named<T>(pub Vec<(&'static str, T)>);

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// Writes a value as a readable JSON file.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::other(error.to_string()))?;
    Ok(write_file(path, (text + "\n").as_bytes())?)
}
