//! A binary bounding volume hierarchy with 32-byte nodes: built by obvhs, walked here with a margin around every box.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{leaf_collapser::collapse, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Nodes a walk keeps without touching the heap.
const STACK: usize = 64;

struct Node {
    min: [f32; 3],
    /// First entry of the leaf, or the first of two neighbouring children.
    first: u32,
    max: [f32; 3],
    /// Entries of the leaf; 0 for an inner node.
    count: u32,
}

/// A hierarchy over entries `0..n`, in the order that [`Bvh::build`] returns.
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    /// Lower corner of all entries.
    pub(crate) min: DVec3,
    /// Upper corner of all entries.
    pub(crate) max: DVec3,
}

/// A line for box tests. Boxes grow by `margin` on every side, so it also stands for a bundle of parallel rays.
pub(crate) struct BoxRay {
    origin: Vec3A,
    inverse: Vec3A,
    margin: Vec3A,
    t_max: f32,
}

impl Bvh {
    /// Builds over `boxes` and returns the new order of the entries: `order[new] = old`.
    pub(crate) fn build(boxes: &[Aabb]) -> (Bvh, Vec<u32>) {
        if boxes.is_empty() {
            return (Bvh { nodes: Vec::new(), min: DVec3::ZERO, max: DVec3::ZERO }, Vec::new());
        }
        // obvhs' fast preset with smaller leaves; its own helper would validate the tree in debug builds, which takes longer
        let order = (0..boxes.len() as u32).collect();
        let mut built = PlocBuilder::new().build(PlocSearchDistance::Low, boxes, order, SortPrecision::U64, 2);
        ReinsertionOptimizer::default().run(&mut built, 0.02, None);
        collapse(&mut built, 4, 3.0);
        let nodes: Vec<Node> = built
            .nodes
            .iter()
            .map(|n| Node {
                min: n.aabb().min.into(),
                first: n.first_index,
                max: n.aabb().max.into(),
                count: n.prim_count,
            })
            .collect();
        let root = built.nodes[0].aabb();
        (Bvh { nodes, min: root.min.as_dvec3(), max: root.max.as_dvec3() }, built.primitive_indices)
    }

    /// Memory of the nodes, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(&self.nodes[..]) as u64
    }

    /// The part of the bundle of rays `origin + t * direction`, `origin` uncertain by `spread` on each axis, that can
    /// meet the hierarchy before `t_max`. The line starts where the bundle enters the bounds: f32 then loses nothing
    /// to a distant origin.
    pub(crate) fn enter(&self, origin: DVec3, spread: f64, direction: DVec3, t_max: f64) -> Option<BoxRay> {
        if self.nodes.is_empty() {
            return None;
        }
        let tiny = 1e-12 * direction.abs().max_element();
        let d = DVec3::from_array(direction.to_array().map(|c| if c.abs() < tiny { tiny.copysign(c) } else { c }));
        // f32 boxes and slab tests are off by at most 5 roundings (2^-24 each) of the coordinates involved, which stay within the bounds
        let margin = spread + 2e-6 * self.min.abs().max(self.max.abs()).max_element();
        let a = (self.min - margin - origin) / d;
        let b = (self.max + margin - origin) / d;
        let t_in = a.min(b).max_element().max(0.0);
        let t_out = a.max(b).min_element().min(t_max);
        if t_in > t_out {
            return None;
        }
        Some(BoxRay {
            origin: (origin + d * t_in).as_vec3a(),
            inverse: (1.0 / d).as_vec3a(),
            margin: Vec3A::splat(margin as f32),
            t_max: ((t_out - t_in) * (1.0 + 1e-6)) as f32 + f32::MIN_POSITIVE,
        })
    }

    /// Calls `visit` with the entries of every leaf that `ray` may meet, nearer child first, until it returns true.
    pub(crate) fn walk(&self, ray: &BoxRay, mut visit: impl FnMut(std::ops::Range<usize>) -> bool) {
        let mut stack = [0u32; STACK];
        let mut depth = 0;
        let mut spill: Vec<u32> = Vec::new();
        let mut index = 0u32;
        if ray.entry(&self.nodes[0]).is_none() {
            return;
        }
        loop {
            let node = &self.nodes[index as usize];
            let mut next = None;
            if node.count > 0 {
                if visit(node.first as usize..(node.first + node.count) as usize) {
                    return;
                }
            } else {
                let (left, right) = (node.first, node.first + 1);
                let l = ray.entry(&self.nodes[left as usize]);
                let r = ray.entry(&self.nodes[right as usize]);
                next = match (l, r) {
                    (Some(a), Some(b)) => {
                        let (near, far) = if a <= b { (left, right) } else { (right, left) };
                        if depth < STACK {
                            stack[depth] = far;
                            depth += 1;
                        } else {
                            spill.push(far);
                        }
                        Some(near)
                    }
                    (Some(_), None) => Some(left),
                    (None, Some(_)) => Some(right),
                    (None, None) => None,
                };
            }
            index = match next.or_else(|| spill.pop()) {
                Some(i) => i,
                None if depth > 0 => {
                    depth -= 1;
                    stack[depth]
                }
                None => return,
            };
        }
    }
}

impl BoxRay {
    #[inline(always)]
    fn entry(&self, node: &Node) -> Option<f32> {
        let a = (Vec3A::from_array(node.min) - self.margin - self.origin) * self.inverse;
        let b = (Vec3A::from_array(node.max) + self.margin - self.origin) * self.inverse;
        let t_in = a.min(b).max_element().max(0.0);
        let t_out = a.max(b).min_element().min(self.t_max);
        (t_in <= t_out).then_some(t_in)
    }
}
