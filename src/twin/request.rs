//! Which page each pixel asks for, and how many pixels ask for each.
//!
//! Single precision in the order of the shader, without fused operations. A device may fuse, and divides less exactly,
//! so a pixel near the border of a page, of a level or of facing the light may ask for a neighbour: [`Requests::near`]
//! lists these pixels with all pages they may ask for. Every other pixel must ask for exactly its page.

use super::ROOT_LEVEL;
use super::SHIFTS;
use super::key::key_of;
use super::receiver::{decode_derivatives, decode_normal, linear_depth, pixel_ray, xyz};
use crate::gpu::structs::Frame;
use glam::Vec2;
use std::collections::{BTreeMap, BTreeSet};

/// Share of a position, of a squared footprint or of n.l within which a border is near.
pub const NEAR: f32 = 1e-5;

/// What the pixels ask for in one attempt.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Requests {
    /// Pixels of each key, by plain single precision.
    pub pixels: BTreeMap<u32, u32>,
    /// Entries of the list that the sort route appends: each key once for each 8x8 pixels that hold it.
    pub entries: u32,
    /// For each pixel near a border: its own key, then the others it may ask for. 0 is no page.
    pub near: Vec<(u32, BTreeSet<u32>)>,
}

/// Runs one attempt with all requests `shift` levels coarser.
pub fn request(frame: &Frame, depth: &[f32], receiver: &[[u32; 4]], shift: u32) -> Requests {
    let width = frame.size[0];
    let mut out = Requests::default();
    let mut groups = BTreeSet::new();
    for (i, (&stored, &receiver)) in depth.iter().zip(receiver).enumerate() {
        let pixel = [i as u32 % width, i as u32 / width];
        let (key, others) = pixel_keys(frame, pixel, stored, receiver, shift);
        if key != 0 {
            *out.pixels.entry(key).or_default() += 1;
            groups.insert((pixel[0] / 8, pixel[1] / 8, key));
        }
        if others.iter().any(|&other| other != key) {
            out.near.push((key, others));
        }
    }
    out.entries = groups.len() as u32;
    out
}

/// The attempts as the GPU makes them: coarser until `asked` is at most `capacity`; the last always counts.
pub fn attempts(
    frame: &Frame,
    depth: &[f32],
    receiver: &[[u32; 4]],
    capacity: u32,
    asked: impl Fn(&Requests) -> u32,
) -> Vec<Requests> {
    let mut made: Vec<Requests> = Vec::new();
    for shift in SHIFTS {
        if made.last().is_none_or(|last| asked(last) > capacity) {
            made.push(request(frame, depth, receiver, shift));
        }
    }
    made
}

/// The key of a pixel and all keys that rounding could make of it; 0 when it asks for nothing.
pub fn pixel_keys(frame: &Frame, pixel: [u32; 2], stored: f32, receiver: [u32; 4], shift: u32) -> (u32, BTreeSet<u32>) {
    let mut others = BTreeSet::new();
    if stored <= 0.0 {
        return (0, others);
    }
    let facing = decode_normal(receiver[0]).dot(xyz(frame.light_z));
    if facing > NEAR {
        return (0, others);
    }
    let depth = linear_depth(frame, stored);
    let from_eye = pixel_ray(frame, pixel) * depth;
    let across = |v| Vec2::new(xyz(frame.light_x).dot(v), xyz(frame.light_y).dot(v));
    let ls = across(from_eye);
    let start = Vec2::new(frame.light_x[3], frame.light_y[3]);
    let units = start + ls * frame.page[1];
    let derivatives = decode_derivatives(frame, receiver, depth);
    let [dx, dy] = derivatives.map(across);
    let squared = match frame.size[2] {
        0 => (dx.x * dy.y - dx.y * dy.x).abs(),
        _ => (dx.x * dx.x + dx.y * dx.y).min(dy.x * dy.x + dy.y * dy.y),
    };
    // each coordinate may lose a few units of the vector's length; depth scales all alike
    let lost = derivatives.map(|d| 4.0 * f32::EPSILON * d.length());
    let room = NEAR * squared
        + match frame.size[2] {
            0 => dx.length() * lost[1] + dy.length() * lost[0],
            _ => (2.0 * dx.length() * lost[0]).max(2.0 * dy.length() * lost[1]) + lost[0].max(lost[1]).powi(2),
        };
    let level = |squared: f32| {
        let exponent = ((squared.max(0.0) * frame.rule[0]).to_bits() >> 23 & 255) as i32 - 127;
        ((exponent >> 1).clamp(0, ROOT_LEVEL) + shift as i32).min(ROOT_LEVEL)
    };
    let page = |units: Vec2| [units.x.floor() as i32 + frame.eye_page[0], units.y.floor() as i32 + frame.eye_page[1]];
    let key = |page: [i32; 2], level: i32| {
        let on_grid = page.iter().all(|c| (0..2 << ROOT_LEVEL).contains(c));
        if on_grid { key_of(level, page.map(|c| c as u32 >> level)) } else { 0 }
    };
    // positions relative to the eye lose a few units in the last place of the longest sum that made them
    let reach = NEAR * (from_eye.length() * frame.page[1] * 0.1 + 1.0);
    for x in [-reach, reach] {
        for y in [-reach, reach] {
            for s in [squared - room, squared + room] {
                others.insert(key(page(units + Vec2::new(x, y)), level(s)));
            }
        }
    }
    if facing.abs() <= NEAR {
        others.insert(0);
    }
    (if facing >= 0.0 { 0 } else { key(page(units), level(squared)) }, others)
}
