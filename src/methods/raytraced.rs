//! The reference: one ray a pixel on all CPU cores, alpha honoured; and what a second ray tracer differs from it by.

use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::Light;
use crate::lab::{Lab, LabError};
use crate::scene::Scene;
use crate::truth::{GBuffer, Tracer, Turned, trace_visibility};
use std::rc::Rc;
use std::time::Instant;

const PARAMETERS: &[Parameter] = &[Parameter {
    key: "turned",
    default: "false",
    allowed: "true or false",
    meaning: "traces a copy of scene, samples and lights that is turned, shifted and rounded to f32 again: its errors are the floor below which errors say nothing",
}];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "raytraced",
    source: "Appel 1968; the reference of all error figures",
    summary: "One ray from every visible sample to each light through a BVH, on the CPU",
    parameters: PARAMETERS,
    check: |spec| turned(spec).map(|_| ()),
    create: |spec, _| Ok(Box::new(Raytraced::new(spec)?)),
};

fn turned(spec: &MethodSpec) -> Result<bool, LabError> {
    Ok(spec.one_of("turned", "false", &["true", "false"])? == "true")
}

pub(super) struct Raytraced {
    /// By light.
    visibility: Vec<Vec<f32>>,
    turned: bool,
    copy: Option<TurnedCopy>,
    /// Of the BVH, after the first frame.
    bytes: u64,
}

/// The turned copy of what the lab shows.
struct TurnedCopy {
    /// The samples it was made from: the lab makes others whenever scene or camera change.
    of: Rc<GBuffer>,
    by: Turned,
    /// Origin and bounds only.
    scene: Scene,
    tracer: Tracer,
    gbuffer: GBuffer,
}

impl TurnedCopy {
    fn new(lab: &Lab, of: Rc<GBuffer>) -> Self {
        let (by, scene) = (Turned::new(lab.scene()), lab.scene());
        let (origin, bounds_min, bounds_max) = (scene.origin, scene.bounds_min, scene.bounds_max);
        Self {
            tracer: Tracer::new(&by.scene(scene)),
            gbuffer: by.gbuffer(&of),
            scene: Scene { origin, bounds_min, bounds_max, ..Scene::default() },
            of,
            by,
        }
    }
}

impl Raytraced {
    pub(super) fn new(spec: &MethodSpec) -> Result<Self, LabError> {
        Ok(Self { visibility: Vec::new(), turned: turned(spec)?, copy: None, bytes: 0 })
    }

    /// Traces all lights of the view.
    fn trace(&mut self, lab: &Lab) -> Result<f64, LabError> {
        let gbuffer = lab.gbuffer()?;
        let lights = lab.view().lights.iter();
        let (tracer, scene, gbuffer, lights) = if self.turned {
            let copy = self.copy.take().filter(|copy| Rc::ptr_eq(&copy.of, &gbuffer));
            let copy = self.copy.insert(copy.unwrap_or_else(|| TurnedCopy::new(lab, gbuffer)));
            let lights = lights.map(|light| copy.by.light(light)).collect();
            (&copy.tracer, &copy.scene, &copy.gbuffer, lights)
        } else {
            (lab.tracer(), lab.scene(), &*gbuffer, lights.cloned().collect::<Vec<Light>>())
        };
        self.bytes = tracer.bytes();
        let start = Instant::now();
        let visibility: Result<_, _> =
            lights.iter().map(|light| trace_visibility(tracer, scene, gbuffer, light)).collect();
        let ms = start.elapsed().as_secs_f64() * 1e3;
        self.visibility = visibility.map_err(|error| LabError::Refused(error.to_string()))?;
        Ok(ms)
    }
}

impl Method for Raytraced {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let ms = self.trace(lab)?;
        Ok(FrameTimes { prepass_ms: 0.0, ms, wall_ms: ms, stages: vec![("trace", ms)] })
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        lab.light(light)?;
        Ok(self.visibility.get(light).cloned().unwrap_or_default())
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        vec![("bvh", self.bytes)]
    }

    fn statistics(&mut self, _lab: &Lab) -> Result<Statistics, LabError> {
        Ok(Statistics::default())
    }
}
