//! From requested pages to page table entries: the quadtree above the requests, the order of service, the cut that fits
//! the atlas, and which page serves each node. Sums are exact; see `glsl/shared/refine.glsl` for the ranks.

use super::key::{key_ancestor, key_level};
use super::{ROOT_LEVEL, SHIFTS};
use std::collections::{BTreeMap, BTreeSet};

const RANKS: u32 = 2048;

/// A page of the quadtree.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Node {
    /// Pixels that ask for exactly this page.
    pub own: u64,
    /// Pixels that ask for a finer page inside it, weighted with 2^(levels between), at most `weight_bits` of them.
    pub below: u64,
    /// Order of service of an inner node; 0 for leaves.
    pub rank: u32,
    /// Keys of the children by quadrant, 0 where there is none.
    pub child: [u32; 4],
}

/// The tree and the pages chosen.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Allocation {
    /// Levels by which the requests were coarsened.
    pub shift: u32,
    /// Keys asked for after coarsening.
    pub leaves: BTreeSet<u32>,
    /// All nodes by key.
    pub nodes: BTreeMap<u32, Node>,
    /// Least rank that is refined.
    pub threshold: u32,
    /// Keys of the pages chosen, in order; the index is the layer of the atlas.
    pub pages: Vec<u32>,
}

/// What serves whom.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Service {
    /// Page table entry of every node.
    pub entries: BTreeMap<u32, u32>,
    /// Keys asked for, per level.
    pub requested: [u32; 16],
    /// Of these, those that a page more than `tolerance` levels coarser serves, or none.
    pub refused: [u32; 16],
}

fn rank(node: &Node, level: i32) -> (u32, u32) {
    let children = node.child.iter().filter(|&&c| c != 0).count() as u32;
    if children == 0 {
        return (0, 0);
    }
    let cost = children - u32::from(node.own == 0 && level < ROOT_LEVEL);
    let benefit = node.below / 2;
    let rank = if cost == 0 {
        RANKS - 1
    } else {
        let whole = if benefit < 1 << 27 {
            (benefit << 4) / u64::from(cost)
        } else {
            (benefit / u64::from(cost)).min(0x0fff_ffff) << 4
        };
        let whole = whole.max(1);
        let high = whole.ilog2();
        let seven_bits = if high >= 6 { whole >> (high - 6) } else { whole << (6 - high) };
        (high * 64 + (seven_bits & 63) as u32).clamp(1, RANKS - 2)
    };
    (rank, cost)
}

/// Chooses pages for `requests` (pixels by key) when the table takes `request_capacity` keys and the atlas
/// `page_capacity` pages; `weight_bits` is [`crate::Config::weight_bits`]. `runs` are those of [`super::compact::Compacted`].
pub fn allocate(
    requests: &BTreeMap<u32, u32>,
    runs: [u32; 4],
    request_capacity: u32,
    page_capacity: u32,
    weight_bits: u32,
) -> Allocation {
    let fits = runs[..3].iter().position(|&r| r <= request_capacity).unwrap_or(3);
    let mut out = Allocation { shift: SHIFTS[fits], ..Allocation::default() };
    for root in 0..4 {
        out.nodes.insert(1 << 28 | root, Node::default());
    }
    for (&key, &count) in requests {
        let leaf = key_ancestor(key, out.shift);
        out.leaves.insert(leaf);
        out.nodes.entry(leaf).or_default().own += u64::from(count);
    }
    for &leaf in &out.leaves {
        let own = out.nodes[&leaf].own;
        let mut child = leaf;
        for distance in 1..=(ROOT_LEVEL - key_level(leaf)) as u32 {
            let key = key_ancestor(leaf, distance);
            let node = out.nodes.entry(key).or_default();
            node.below += own << distance.min(weight_bits);
            node.child[child as usize & 3] = child;
            child = key;
        }
    }
    // a node's rank is the least on its path to the root
    let own_ranks: BTreeMap<u32, (u32, u32)> = out.nodes.iter().map(|(&k, n)| (k, rank(n, key_level(k)))).collect();
    let mut cost_of = vec![0u64; RANKS as usize];
    for (&key, node) in &mut out.nodes {
        let (_, cost) = own_ranks[&key];
        if node.child != [0; 4] {
            let path = 0..=(ROOT_LEVEL - key_level(key)) as u32;
            node.rank = path.map(|steps| own_ranks[&key_ancestor(key, steps)].0).min().unwrap_or(0);
            cost_of[node.rank as usize] += u64::from(cost);
        }
    }
    let budget = u64::from(page_capacity - 4);
    let fits = |&least: &u32| cost_of[least as usize..].iter().sum::<u64>() <= budget;
    out.threshold = (1..RANKS).find(fits).unwrap_or(RANKS);
    let refined = |key: u32| {
        let node = &out.nodes[&key];
        node.child != [0; 4] && node.rank >= out.threshold
    };
    let chosen = |key: u32| {
        key_level(key) == ROOT_LEVEL || (refined(key_ancestor(key, 1)) && (!refined(key) || out.nodes[&key].own > 0))
    };
    out.pages = out.nodes.keys().copied().filter(|&key| chosen(key)).collect();
    out
}

impl Allocation {
    /// Page table entries when only the `drawn` pages can serve; `tolerance`: levels a request may be served coarser.
    pub fn serve(&self, drawn: impl Fn(u32) -> bool, tolerance: i32) -> Service {
        let layers: BTreeMap<u32, u32> = self.pages.iter().copied().zip(0..).filter(|&(key, _)| drawn(key)).collect();
        let mut out = Service::default();
        for &key in self.nodes.keys() {
            let level = key_level(key);
            let path = 0..=(ROOT_LEVEL - level) as u32;
            let served =
                path.map(|steps| key_ancestor(key, steps)).find_map(|k| Some((key_level(k), *layers.get(&k)?)));
            let entry = served.map_or(0, |(level, layer)| 1 << 31 | (level as u32) << 16 | layer);
            out.entries.insert(key, entry);
            if self.leaves.contains(&key) {
                out.requested[level as usize] += 1;
                out.refused[level as usize] +=
                    u32::from(served.is_none_or(|(l, _)| l > level - self.shift as i32 + tolerance));
            }
        }
        out
    }
}
