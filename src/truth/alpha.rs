//! Alpha of a surface point: the exact rule that the shaders' alpha test mirrors. All arithmetic is in f32.

use crate::scene::{Material, NO_TEXTURE};

const REPEAT: u32 = 0;
const MIRROR: u32 = 1;

/// Alpha at texture coordinate `uv`: base colour alpha * bilinear texture alpha at the base level * `vertex_alpha`.
///
/// `uv` is taken before the material's texture transform. `texel(i)` returns the alpha byte of texel `i` of
/// [`crate::scene::Scene::texels`]; texel centres lie at +0.5 and row 0 holds v = 0. The point is cut away where the
/// result is less than [`Material::alpha_cutoff`].
pub fn alpha_at(material: &Material, texel: impl Fn(u32) -> u8, uv: [f32; 2], vertex_alpha: f32) -> f32 {
    let factor = material.base_color[3] * vertex_alpha;
    if material.texel_offset == NO_TEXTURE || material.width == 0 || material.height == 0 {
        return factor;
    }
    let (w, h) = (material.width, material.height);
    let (r0, r1) = (material.uv_row0, material.uv_row1);
    let x = (r0[0] * uv[0] + r0[1] * uv[1] + r0[2]) * w as f32 - 0.5;
    let y = (r1[0] * uv[0] + r1[1] * uv[1] + r1[2]) * h as f32 - 0.5;
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    let (ix, iy) = (x0 as i32, y0 as i32);
    let columns = [wrap(ix, w, material.wrap & 3), wrap(ix.saturating_add(1), w, material.wrap & 3)];
    let rows = [wrap(iy, h, material.wrap >> 2 & 3), wrap(iy.saturating_add(1), h, material.wrap >> 2 & 3)];
    let at = |r: usize, c: usize| f32::from(texel(material.texel_offset + rows[r] * w + columns[c])) / 255.0;
    let mix = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
    factor * mix(mix(at(0, 0), at(0, 1), fx), mix(at(1, 0), at(1, 1), fx), fy)
}

/// Texel index in `0..size` for the unbounded index `i`. `mode`: 0 repeat, 1 mirrored repeat, 2 clamp to edge.
fn wrap(i: i32, size: u32, mode: u32) -> u32 {
    let (i, n) = (i64::from(i), i64::from(size));
    let wrapped = match mode {
        REPEAT => i.rem_euclid(n),
        MIRROR => {
            let m = i.rem_euclid(2 * n);
            m.min(2 * n - 1 - m)
        }
        _ => i.clamp(0, n - 1),
    };
    wrapped as u32
}
