//! From requested pages to page table entries: the quadtree above the requests, the order of service, the cut that fits
//! the atlas and the budget of drawing, and which page serves each node. Sums are exact; see `glsl/shared/refine.glsl`
//! for the ranks.

use super::compact::compact;
use super::key::{key_ancestor, key_face, key_hash, key_level, key_of, key_quadrant, to_morton};
use super::{FACES, ROOT_LEVEL, SHIFTS};
use crate::{Config, Pressure};
use std::collections::{BTreeMap, BTreeSet};

const RANKS: u32 = 2048;
const ALL_RANKS: u32 = 4096;
const ORDERS: u32 = 8192;
/// No layer of the atlas.
pub const NONE: u32 = u32::MAX;

/// What allocation starts from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Input {
    /// Pixels by key.
    pub requests: BTreeMap<u64, u32>,
    /// Slots of directional lights: the roots of their faces always exist.
    pub directional: Vec<u32>,
    /// Pages that layers hold from earlier frames, in the order of the layers, and whether they are still right.
    pub held: Vec<(u64, bool)>,
    /// Pages that moving casters touch.
    pub moving: BTreeSet<u64>,
    /// Most layers to draw.
    pub draw_budget: u32,
}

impl Input {
    /// The requests as they are sorted: Morton form and pixels.
    pub fn list(&self) -> Vec<(u64, u32)> {
        let mut list: Vec<_> = self.requests.iter().map(|(&key, &pixels)| (to_morton(key), pixels)).collect();
        list.sort_unstable();
        list
    }
}

/// What refining a node does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Refinement {
    /// Layers of the atlas taken, less those freed.
    pub layers: i32,
    /// Layers to draw, less those that need not be drawn any more.
    pub draws: i32,
    /// Order of service of this node alone.
    pub own_rank: u32,
    /// Least `own_rank` on the path to the root.
    pub rank: u32,
    /// The same over nodes whose refining draws, for which the highest rank is not used.
    pub draw_rank: u32,
}

/// A page of the quadtree.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Node {
    /// Pixels that ask for exactly this page.
    pub own: u64,
    /// Pixels that ask for a finer page inside it, weighted with 2^(levels between), at most `weight_bits` of them.
    pub below: u64,
    /// Of inner nodes.
    pub refinement: Option<Refinement>,
    /// Layer that holds it, and whether that is still right.
    pub held: Option<(u32, bool)>,
    /// Whether moving casters touch it.
    pub moving: bool,
    /// Whether the cached and the dynamic layer of this page, or of one below it, are drawn.
    pub drawn: [bool; 2],
    /// Keys of the children by quadrant, 0 where there is none.
    pub child: [u64; 4],
}

impl Node {
    /// Layers of the atlas that the page needs.
    pub fn layers(&self) -> i32 {
        1 + i32::from(self.moving)
    }

    /// Which of them must be drawn when the page is chosen: the cached one, the dynamic one.
    pub fn to_draw(&self) -> [bool; 2] {
        [!self.held.is_some_and(|(_, valid)| valid), self.moving]
    }

    /// Number of layers that must be drawn when the page is chosen.
    pub fn draws(&self) -> i32 {
        self.to_draw().map(i32::from).iter().sum()
    }

    /// The words of the device's node: cost, ranks, slot, marks.
    pub fn words(&self) -> [u32; 4] {
        let [cost, ranks] = self.refinement.map_or([0; 2], |r| {
            let [draws, layers] = [r.draws, r.layers].map(|n| (n + 16) as u32);
            [r.own_rank | draws << 16 | layers << 24, r.rank | r.draw_rank << 16]
        });
        let slot = self.held.map_or(0, |(layer, valid)| (layer + 1) | u32::from(!valid) << 31);
        let [cached, dynamic] = self.drawn.map(u32::from);
        [cost, ranks, slot, u32::from(self.moving) | cached << 1 | dynamic << 2]
    }
}

/// A page chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Page {
    /// The page.
    pub key: u64,
    /// Its layer: that which holds it, else the first of two of its own after all that are held.
    pub slot: u32,
    /// The layer of its moving casters, the second of its own; [`NONE`] where there are none.
    pub dynamic_slot: u32,
    /// Bit 0: the layer must be drawn; bit 1: that of the moving casters.
    pub draws: u32,
}

/// The tree and the pages chosen.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Allocation {
    /// Levels by which the requests were coarsened.
    pub shift: u32,
    /// Keys asked for after coarsening.
    pub leaves: BTreeSet<u64>,
    /// Ranks of the roots.
    pub roots: BTreeMap<u64, u32>,
    /// All nodes by key.
    pub nodes: BTreeMap<u64, Node>,
    /// Least rank that is refined.
    pub threshold: u32,
    /// Least rank that is refined where that draws; 0 when all may be drawn.
    pub draw_threshold: u32,
    /// Place in the order of the rank before, up to which nodes are refined too.
    pub draw_order: u32,
    /// Layers to draw if there were no budget for it.
    pub draws_asked: u32,
    /// Of these, those that are put off.
    pub deferred: u32,
    /// The pages chosen, in the order of their keys.
    pub pages: Vec<Page>,
    /// Pages chosen that are held and right.
    pub hits: u32,
    /// Pages chosen that are held but wrong.
    pub stale: u32,
}

/// What serves whom.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Service {
    /// Page table entry of every node.
    pub entries: BTreeMap<u64, u32>,
    /// Keys asked for, per level.
    pub requested: [u32; 24],
    /// Of these, those that a page more than `tolerance` levels coarser serves, or none.
    pub refused: [u32; 24],
    /// Layers to draw that are put off: those of [`Allocation`] and those of chosen pages that do not serve.
    pub deferred: u32,
    /// Faces that no page serves.
    pub starved: u32,
}

/// 64 steps an octave of benefit / cost.
fn benefit_rank(benefit: u64, cost: i32) -> u32 {
    let Ok(cost @ 1..) = u64::try_from(cost) else { return RANKS - 1 };
    let ratio = if benefit < 1 << 27 { (benefit << 4) / cost } else { (benefit / cost).min(0x0fff_ffff) << 4 };
    let ratio = ratio.max(1);
    let high = ratio.ilog2();
    let seven_bits = if high >= 6 { ratio >> (high - 6) } else { ratio << (6 - high) };
    (high * 64 + (seven_bits & 63) as u32).clamp(1, RANKS - 2)
}

/// Rank of a root; `directional`: its light is one.
fn root_rank(key: u64, node: &Node, directional: bool) -> u32 {
    let capped = |pixels: u64| pixels.min(0x3fff_ffff);
    let benefit = capped(node.own) + capped(node.below);
    let rank = if directional { RANKS - 1 } else { benefit_rank(benefit, node.layers()).min(RANKS - 33) };
    RANKS + (rank & !31 | key_hash(key) & 31)
}

/// Keys from `key` to its root.
fn path(key: u64) -> impl Iterator<Item = u64> {
    (0..=(ROOT_LEVEL - key_level(key)) as u32).map(move |steps| key_ancestor(key, steps))
}

/// Least rank above 0 whose costs, with those of all higher ranks, are within the budget.
fn least_rank(costs: &[(u32, i32)], budget: i32) -> u32 {
    let sum = |least: u32| costs.iter().filter(|&&(rank, _)| rank >= least).map(|&(_, cost)| cost).sum::<i32>();
    (1..ALL_RANKS).find(|&least| sum(least) <= budget).unwrap_or(ALL_RANKS)
}

/// Order of the nodes of one rank, coarse levels first: `draw_order` of `glsl/shared/refine.glsl`.
fn order(key: u64) -> u32 {
    ((ROOT_LEVEL - key_level(key)) as u32 * ORDERS + key_hash(key) % ORDERS) / 24
}

/// The last place in the order before which the costs are within the budget.
fn last_order(costs: &[(u32, i32)], budget: i32) -> u32 {
    let mut at = vec![0; ORDERS as usize];
    costs.iter().for_each(|&(order, cost)| at[order as usize] += cost);
    let sums = at.iter().scan(0, |sum, cost| {
        *sum += cost;
        Some(*sum)
    });
    (1..).zip(sums).filter(|&(_, sum)| sum <= budget).last().map_or(0, |(end, _)| end)
}

/// The quadtree above the requests, with what is known of its pages.
fn tree(input: &Input, config: &Config) -> Allocation {
    let runs = compact(&input.list()).runs;
    let fits = runs[..3].iter().position(|&r| r <= config.request_capacity()).unwrap_or(3);
    let mut out = Allocation { shift: SHIFTS[fits], ..Allocation::default() };
    for &light in &input.directional {
        out.nodes.insert(key_of(ROOT_LEVEL, light * FACES, [0, 0]), Node::default());
    }
    for (&key, &count) in &input.requests {
        let leaf = key_ancestor(key, out.shift);
        out.leaves.insert(leaf);
        out.nodes.entry(leaf).or_default().own += u64::from(count);
    }
    // one view of the largest size
    let weight_bits = config.weight_bits(config.size.map(u64::from).into_iter().product());
    for &leaf in &out.leaves {
        let own = out.nodes[&leaf].own;
        let mut child = leaf;
        for (distance, key) in (0..).zip(path(leaf)).skip(1) {
            let node = out.nodes.entry(key).or_default();
            node.below += own << weight_bits.min(distance);
            node.child[key_quadrant(child)] = child;
            child = key;
        }
    }
    for (key, node) in &mut out.nodes {
        node.held = (0..).zip(&input.held).find(|(_, held)| held.0 == *key).map(|(layer, held)| (layer, held.1));
        node.moving = input.moving.contains(key);
    }
    out
}

impl Allocation {
    fn refinement(&self, key: u64, pressure: Pressure) -> Option<Refinement> {
        let node = &self.nodes[&key];
        let children: Vec<_> = node.child.iter().filter_map(|child| self.nodes.get(child)).collect();
        if children.is_empty() {
            return None;
        }
        // its own page goes when no pixel needs that any more; roots always stay
        let gone = (node.own == 0 && key_level(key) < ROOT_LEVEL).then_some(node);
        let sum = |of: fn(&Node) -> i32| children.iter().map(|n| of(n)).sum::<i32>() - gone.map_or(0, of);
        let layers = sum(Node::layers);
        let own_rank = match pressure {
            Pressure::Level if layers > 0 => 64 * key_level(key) as u32,
            _ => benefit_rank(node.below / 2, layers),
        };
        Some(Refinement { layers, draws: sum(Node::draws), own_rank, ..Refinement::default() })
    }

    /// Keys of the chosen pages if the nodes from these ranks on are refined, and those of the rank before `draw_threshold`
    /// that come before `draw_order`.
    fn cut(&self, threshold: u32, draw_threshold: u32, draw_order: u32) -> Vec<u64> {
        let drawn =
            |rank: u32, key: u64| rank >= draw_threshold || rank + 1 == draw_threshold && order(key) < draw_order;
        let refined =
            |key: u64| self.nodes[&key].refinement.is_some_and(|r| r.rank >= threshold && drawn(r.draw_rank, key));
        let chosen = |key: u64, node: &Node| match self.roots.get(&key) {
            Some(&rank) => rank >= threshold && (node.draws() == 0 || drawn(rank, key)),
            None => refined(key_ancestor(key, 1)) && (!refined(key) || node.own > 0),
        };
        self.nodes.iter().filter(|&(&key, node)| chosen(key, node)).map(|(&key, _)| key).collect()
    }
}

/// Chooses pages, within what the page table and the atlas of `config` hold and what may be drawn.
pub fn allocate(input: &Input, config: &Config) -> Allocation {
    let mut out = tree(input, config);
    let own: BTreeMap<u64, Refinement> =
        out.nodes.keys().filter_map(|&key| Some((key, out.refinement(key, config.pressure)?))).collect();
    // the least on the path, so that the refined nodes are connected
    for (&key, &refinement) in &own {
        let rank = path(key).map(|k| own[&k].own_rank).min().unwrap_or(0);
        let drawing = path(key).map(|k| own[&k]).filter(|r| r.draws > 0);
        let draw_rank = drawing.map(|r| r.own_rank.min(RANKS - 2)).min().unwrap_or(RANKS - 1);
        out.nodes.entry(key).or_default().refinement = Some(Refinement { rank, draw_rank, ..refinement });
    }
    for (&key, node) in out.nodes.iter().filter(|(key, _)| key_level(**key) == ROOT_LEVEL) {
        let directional = input.directional.contains(&(key_face(key) / FACES));
        out.roots.insert(key, root_rank(key, node, directional));
    }
    let sum = |keys: &[u64], of: fn(&Node) -> i32| keys.iter().map(|key| of(&out.nodes[key])).sum::<i32>();
    let inner = || out.nodes.values().filter_map(|node| node.refinement);
    let roots = || out.roots.iter().map(|(key, &rank)| (*key, rank, &out.nodes[key]));

    let layers: Vec<_> =
        inner().map(|r| (r.rank, r.layers)).chain(roots().map(|(_, rank, node)| (rank, node.layers()))).collect();
    let threshold = least_rank(&layers, config.chosen_layers() as i32);
    let mut chosen = out.cut(threshold, 0, 0);
    let draws_asked = sum(&chosen, Node::draws);
    let (mut draw_threshold, mut draw_order, mut deferred) = (0, 0, 0);
    if draws_asked > input.draw_budget as i32 {
        // rank, key and draws of what would be drawn
        let nodes = out.nodes.iter().filter_map(|(&key, node)| Some((key, node.refinement?)));
        let nodes = nodes.filter(|(_, r)| r.rank >= threshold).map(|(key, r)| (r.draw_rank, key, r.draws));
        let drawn = roots().filter(|&(_, rank, node)| rank >= threshold && node.draws() > 0);
        let all: Vec<_> = nodes.chain(drawn.map(|(key, rank, node)| (rank, key, node.draws()))).collect();
        let ranks: Vec<_> = all.iter().map(|&(rank, _, draws)| (rank, draws)).collect();
        draw_threshold = least_rank(&ranks, input.draw_budget as i32);
        let certain = sum(&out.cut(threshold, draw_threshold, 0), Node::draws);
        let next = all.iter().filter(|(rank, ..)| rank + 1 == draw_threshold);
        let places: Vec<_> = next.map(|&(_, key, draws)| (order(key), draws)).collect();
        draw_order = last_order(&places, input.draw_budget as i32 - certain);
        chosen = out.cut(threshold, draw_threshold, draw_order);
        deferred = (draws_asked - sum(&chosen, Node::draws)).max(0);
    }
    (out.threshold, out.draw_threshold, out.draw_order) = (threshold, draw_threshold, draw_order);
    (out.draws_asked, out.deferred) = (draws_asked as u32, deferred as u32);

    for key in chosen {
        let node = &out.nodes[&key];
        let free = (input.held.len() + 2 * out.pages.len()) as u32;
        let [cached, dynamic] = node.to_draw();
        out.pages.push(Page {
            key,
            slot: node.held.map_or(free, |(layer, _)| layer),
            dynamic_slot: if dynamic { free + 1 } else { NONE },
            draws: u32::from(cached) | u32::from(dynamic) << 1,
        });
        out.hits += u32::from(!cached);
        out.stale += u32::from(cached && node.held.is_some());
        for above in path(key) {
            let drawn = &mut out.nodes.entry(above).or_default().drawn;
            *drawn = [drawn[0] | cached, drawn[1] | dynamic];
        }
    }
    out
}

impl Allocation {
    /// Whether the page was chosen.
    pub fn chose(&self, key: u64) -> bool {
        self.pages.binary_search_by_key(&key, |page| page.key).is_ok()
    }

    /// Layers from earlier frames whose pages were chosen.
    pub fn used(&self) -> BTreeSet<u32> {
        self.pages.iter().filter(|page| self.nodes[&page.key].held.is_some()).map(|page| page.slot).collect()
    }

    /// Page table entries when only the layers of pages that are `ready` can serve: of chosen ones, those drawn; of
    /// others that are held, those that no page took. `tolerance`: levels a request may be served coarser.
    pub fn serve(&self, ready: impl Fn(u64) -> bool, tolerance: i32) -> Service {
        let put_off = self.pages.iter().filter(|page| !ready(page.key)).map(|page| page.draws.count_ones());
        let mut out = Service { deferred: self.deferred + put_off.sum::<u32>(), ..Service::default() };
        let mut layers: BTreeMap<u64, [u32; 2]> =
            self.pages.iter().map(|page| (page.key, [page.slot, page.dynamic_slot])).collect();
        if self.draw_threshold > 0 || out.deferred > 0 {
            // whatever is still right serves while something is put off
            for (&key, node) in &self.nodes {
                if let (Some((layer, true)), false) = (node.held, node.moving) {
                    layers.entry(key).or_insert([layer, NONE]);
                }
            }
        }
        layers.retain(|&key, _| ready(key));
        for &key in self.nodes.keys() {
            let level = key_level(key);
            let served = path(key).find_map(|k| Some((key_level(k), layers.get(&k)?)));
            let entry = served.map_or(0, |(level, &[slot, dynamic])| {
                1 << 31 | (level as u32) << 26 | dynamic.wrapping_add(1) << 12 | slot
            });
            out.entries.insert(key, entry);
            out.starved += u32::from(level == ROOT_LEVEL && entry == 0);
            if self.leaves.contains(&key) {
                out.requested[level as usize] += 1;
                out.refused[level as usize] +=
                    u32::from(served.is_none_or(|(l, _)| l > level - self.shift as i32 + tolerance));
            }
        }
        out
    }
}
