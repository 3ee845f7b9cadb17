//! Which page each pixel asks for, and how many pixels ask for each.
//!
//! Single precision in the order of the shader, without fused operations. A device may fuse, and divides less exactly,
//! so a pixel near the border of a page, of a level or of facing the light may ask for a neighbour: [`Requests::near`]
//! lists these pixels with all pages they may ask for. Every other pixel must ask for exactly its page.

use super::SHIFTS;
use super::key::key_of;
use super::light::{level, receiver};
use super::receiver::{decode_derivatives, decode_normal, pixel_ray};
use super::{FACES, ROOT_LEVEL};
use crate::gpu::structs::{Frame, LightRecord};
use glam::Vec2;
use std::collections::{BTreeMap, BTreeSet};

/// Share of a position, of a squared footprint or of n.l within which a border is near.
pub const NEAR: f32 = 1e-5;

/// What the pixels ask for in one attempt.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Requests {
    /// Pixels of each key, by plain single precision.
    pub pixels: BTreeMap<u64, u32>,
    /// Entries of the list that the sort route appends: each key once for each 8x8 pixels that hold it.
    pub entries: u32,
    /// For each pixel near a border: its own key, then the others it may ask for. 0 is no page.
    pub near: Vec<(u64, BTreeSet<u64>)>,
}

/// Runs one attempt with all requests `shift` levels coarser.
pub fn request(frame: &Frame, lights: &[LightRecord], depth: &[f32], receiver: &[[u32; 4]], shift: u32) -> Requests {
    let width = frame.size[0];
    let mut out = Requests::default();
    let mut groups = BTreeSet::new();
    for (i, (&depth, &receiver)) in depth.iter().zip(receiver).enumerate() {
        let pixel = [i as u32 % width, i as u32 / width];
        for (slot, light) in (0..).zip(lights) {
            let (key, others) = pixel_keys(frame, slot, light, pixel, depth, receiver, shift);
            if key != 0 {
                *out.pixels.entry(key).or_default() += 1;
                groups.insert((pixel[0] / 8, pixel[1] / 8, key));
            }
            if others.iter().any(|&other| other != key) {
                out.near.push((key, others));
            }
        }
    }
    out.entries = groups.len() as u32;
    out
}

/// The attempts as the GPU makes them: coarser until `asked` is at most `capacity`; the last always counts.
pub fn attempts(
    frame: &Frame,
    lights: &[LightRecord],
    depth: &[f32],
    receiver: &[[u32; 4]],
    capacity: u32,
    asked: impl Fn(&Requests) -> u32,
) -> Vec<Requests> {
    let mut made: Vec<Requests> = Vec::new();
    for shift in SHIFTS {
        if made.last().is_none_or(|last| asked(last) > capacity) {
            made.push(request(frame, lights, depth, receiver, shift));
        }
    }
    made
}

/// The key of a pixel of this depth along the view direction, for a light, and all keys that rounding could make of it; 0 when it asks for nothing.
pub fn pixel_keys(
    frame: &Frame,
    slot: u32,
    light: &LightRecord,
    pixel: [u32; 2],
    depth: f32,
    packed: [u32; 4],
    shift: u32,
) -> (u64, BTreeSet<u64>) {
    let mut others = BTreeSet::new();
    if depth <= 0.0 {
        return (0, others);
    }
    let from_eye = pixel_ray(frame, pixel) * depth;
    let derivatives = decode_derivatives(frame, packed, depth);
    let Some(r) = receiver(frame, light, from_eye, decode_normal(packed[0]), derivatives) else { return (0, others) };
    if r.margin < -NEAR {
        return (0, others);
    }
    let coarse = |squared: f32| (level(light, squared) + shift as i32).min(ROOT_LEVEL);
    let page = |units: Vec2| [units.x.floor() as i32 + r.page[0], units.y.floor() as i32 + r.page[1]];
    let key = |page: [i32; 2], level: i32| {
        let on_face = page.iter().all(|c| (0..1 << ROOT_LEVEL).contains(c));
        if on_face { key_of(level, slot * FACES + r.face, page.map(|c| c as u32 >> level)) } else { 0 }
    };
    // positions relative to the eye lose a few units in the last place of the longest sum that made them
    let reach = NEAR * (r.reach * 0.1 + 1.0);
    for x in [-reach, reach] {
        for y in [-reach, reach] {
            for squared in [r.squared - r.room, r.squared + r.room] {
                others.insert(key(page(r.units + Vec2::new(x, y)), coarse(squared)));
            }
        }
    }
    if r.margin.abs() <= NEAR {
        others.insert(0);
    }
    (if r.margin <= 0.0 { 0 } else { key(page(r.units), coarse(r.squared)) }, others)
}
