//! How a result is compared with its twin. Each refuses a comparison that nothing could fail, and is seen to fail here.

use std::collections::{BTreeMap, BTreeSet};
use umbrage::gpu::structs::Node;
use umbrage::lab::stages::Table;
use umbrage::twin::ROOT_LEVEL;
use umbrage::twin::allocate::{Allocation, Page, Service};
use umbrage::twin::gradient::{Plane, unpack};
use umbrage::twin::key::{from_words, key_ancestor, key_level};
use umbrage::twin::request::Requests;

/// What differs, in one line.
pub type Verdict = Result<(), String>;

/// The same entries in the same order.
pub fn same_entries(want: &[(u64, u32)], got: &[(u64, u32)]) -> Verdict {
    if want.iter().all(|e| *e == (0, 0)) {
        return Err("nothing to compare: no entry, or zeros only".into());
    }
    if let Some(i) = (0..want.len().min(got.len())).find(|&i| want[i] != got[i]) {
        return Err(format!("entry {i} is {:x?}, the twin's is {:x?}", got[i], want[i]));
    }
    if want.len() == got.len() { Ok(()) } else { Err(format!("{} entries, the twin has {}", got.len(), want.len())) }
}

/// Normals bit for bit, derivatives within the twin's tolerance.
pub fn same_planes(want: &[Plane], got: &[[u32; 4]]) -> Verdict {
    if want.iter().all(|p| p.normal == 0) || want.len() != got.len() {
        return Err(format!("nothing to compare: {} planes, the twin has {}, or all are empty", got.len(), want.len()));
    }
    for (i, (want, &got)) in want.iter().zip(got).enumerate() {
        if want.normal != got[0] {
            return Err(format!("pixel {i}: normal {:x}, given was {:x}", got[0], want.normal));
        }
        let values = unpack(got);
        for (axis, value) in values.iter().enumerate() {
            let off = (value - want.derivatives[axis]).abs();
            if off.is_nan() || off > want.tolerance[axis] {
                return Err(format!("pixel {i}: derivatives {values:?}, the twin's are {want:?}"));
            }
        }
    }
    Ok(())
}

/// Largest share of pixels that may lie near a border.
const NEAR_SHARE: f64 = 0.02;

/// Every pixel's page exactly, but pixels near a border may ask for any page their twin lists.
pub fn same_requests(want: &Requests, got: &BTreeMap<u64, u32>) -> Verdict {
    let total: u32 = want.pixels.values().sum();
    if total == 0 {
        return Err("nothing to compare: no pixel asks for a page".into());
    }
    if want.near.len() as f64 > NEAR_SHARE * f64::from(total) + 2.0 {
        return Err(format!("{} of {total} pixels are near a border", want.near.len()));
    }
    let mut sure = want.pixels.clone();
    let mut room = BTreeMap::<u64, u32>::new();
    let mut undecided = 0;
    for (key, others) in &want.near {
        if *key != 0 {
            *sure.get_mut(key).ok_or("the twin's own count is wrong")? -= 1;
        }
        undecided += u32::from(others.contains(&0) || *key == 0);
        for &other in others.iter().chain([key]).collect::<BTreeSet<_>>() {
            *room.entry(other).or_default() += 1;
        }
    }
    for key in got.keys().chain(sure.keys()) {
        let [least, more, count] = [&sure, &room, got].map(|map| map.get(key).copied().unwrap_or(0));
        if count < least || count > least + more {
            return Err(format!("page {key:x} has {count} pixels, the twin has {least} and {more} near a border"));
        }
    }
    let sum: u32 = got.values().sum();
    if sum.abs_diff(total) > undecided {
        return Err(format!("{sum} pixels, the twin has {total} and {undecided} that may ask for none"));
    }
    Ok(())
}

/// The whole page table: tree, ranks, pages, entries, counters; `frame`: that of the layers' last use.
pub fn same_table(want: &Allocation, served: &Service, got: &Table, frame: u32) -> Verdict {
    if want.nodes.len() < 4 || want.pages.len() < 4 || served.entries.len() != want.nodes.len() || frame == 0 {
        return Err(format!("nothing to compare: {} nodes, {} pages", want.nodes.len(), want.pages.len()));
    }
    let same = |what: &str, got: u64, want: u64| {
        if got == want { Ok(()) } else { Err(format!("{what}: {got}, the twin has {want}")) }
    };
    let c = &got.counters;
    same("leaves", c.leaves.into(), want.leaves.len() as u64)?;
    same("nodes", u64::from(c.leaves) + u64::from(c.nodes), want.nodes.len() as u64)?;
    let slots: BTreeMap<u64, &Node> = got.keys.iter().copied().zip(&got.nodes).filter(|(key, _)| *key != 0).collect();
    same("filled slots", slots.len() as u64, want.nodes.len() as u64)?;
    let key_at = |link: u32| {
        if link == 0 { Ok(0) } else { got.keys.get(link as usize - 1).copied().ok_or("a link out of range") }
    };
    for (&key, node) in &want.nodes {
        let gpu = slots.get(&key).ok_or_else(|| format!("node {key:x} is missing"))?;
        let [a, b, c, d] = gpu.child.map(key_at);
        let child = [a?, b?, c?, d?];
        let parent = key_at(gpu.parent)?;
        let want_parent = if key_level(key) == ROOT_LEVEL { 0 } else { key_ancestor(key, 1) };
        let words = [gpu.cost, gpu.ranks, gpu.slot, gpu.marks];
        let read = (u64::from(gpu.own), u64::from(gpu.below), words, child, parent);
        let expected = (node.own, node.below, node.words(), node.child, want_parent);
        if read != expected {
            let what = "(own, below, [cost, ranks, slot, marks], child, parent)";
            return Err(format!("node {key:x}: {what} {read:x?}, the twin's {expected:x?}"));
        }
    }
    let counts = [
        ("failed", c.failed, 0),
        ("shift", c.shift, want.shift),
        ("threshold", c.threshold, want.threshold),
        ("draws asked", c.draws_asked, want.draws_asked),
        ("draw threshold", c.draw_threshold, want.draw_threshold),
        ("draw order", c.draw_order, want.draw_order),
        ("deferred", c.deferred, served.deferred),
        ("starved", c.starved, served.starved),
        ("pages", c.pages, want.pages.len() as u32),
        ("hits", c.hits, want.hits),
        ("stale", c.stale, want.stale),
    ];
    for (what, got, want) in counts {
        same(what, got.into(), want.into())?;
    }
    let read = |p: &umbrage::gpu::structs::Page| Page {
        key: from_words(p.key),
        slot: p.slot,
        dynamic_slot: p.dynamic_slot,
        draws: p.draws,
    };
    let pages: Vec<_> = got.pages.iter().map(read).collect();
    if pages != want.pages {
        return Err(format!("pages {pages:x?}, the twin has {:x?}", want.pages));
    }
    for (i, page) in got.pages.iter().enumerate() {
        let key = from_words(page.key);
        let index = slots[&key].page as usize;
        if got.keys.get(page.node as usize) != Some(&key) || index != i + 1 {
            return Err(format!("page {i} and its node do not name each other: {page:x?}, node.page {index}"));
        }
    }
    let used = want.used();
    for (layer, slot) in (0..).zip(&got.slots) {
        let want = if used.contains(&layer) { frame } else { 0 };
        same(&format!("last use of layer {layer}"), slot.used.into(), want.into())?;
    }
    for (slot, &key) in got.keys.iter().enumerate().filter(|(_, key)| **key != 0) {
        if got.entries[slot] != served.entries[&key] {
            return Err(format!("entry of {key:x}: {:x}, the twin's {:x}", got.entries[slot], served.entries[&key]));
        }
    }
    if (c.requested, c.refused) != (served.requested, served.refused) {
        let (requested, refused) = (c.requested, c.refused);
        return Err(format!(
            "requested {requested:?}, refused {refused:?}, the twin has {:?}, {:?}",
            served.requested, served.refused
        ));
    }
    Ok(())
}

/// The same bits of two visibility images that are neither all lit nor all shadowed.
pub fn same_image(want: &[f32], got: &[f32]) -> Verdict {
    mixed(want)?;
    let differing = want.iter().zip(got).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    if want.len() == got.len() && differing == 0 {
        Ok(())
    } else {
        Err(format!("{differing} of {} pixels differ", want.len()))
    }
}

/// Finite, from 0 to 1, and with at least one pixel in fifty of either kind.
pub fn mixed(image: &[f32]) -> Verdict {
    if let Some(i) = image.iter().position(|v| !(0.0..=1.0).contains(v)) {
        return Err(format!("pixel {i} is {}", image[i]));
    }
    let lit = image.iter().filter(|&&v| v >= 0.5).count();
    if lit.min(image.len() - lit) * 50 < image.len().max(1) {
        return Err(format!("{lit} of {} pixels are lit", image.len()));
    }
    Ok(())
}

mod fail {
    use super::*;
    use bytemuck::Zeroable;
    use umbrage::Config;
    use umbrage::gpu::structs::{Counters, Page, Slot};
    use umbrage::twin::allocate::{Input, allocate};
    use umbrage::twin::key::{key_of, words};

    #[test]
    fn same_entries_can_fail() {
        let want = [(1, 5), (2, 6)];
        assert!(same_entries(&want, &want).is_ok());
        for got in
            [&[(1, 5)][..], &[], &[(1, 5), (2, 7)], &[(2, 6), (1, 5)], &[(1, 5), (2, 6), (2, 6)], &[(0, 0), (0, 0)]]
        {
            assert!(same_entries(&want, got).is_err(), "{got:?}");
        }
        assert!(same_entries(&[], &[]).is_err());
        assert!(same_entries(&[(0, 0)], &[(0, 0)]).is_err());
    }

    #[test]
    fn same_planes_can_fail() {
        let want = [Plane { normal: 7, derivatives: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], tolerance: [1e-3; 6] }];
        assert!(same_planes(&want, &[[7, 0x3c00, 0, 0]]).is_ok());
        assert!(same_planes(&want, &[[7, 0x3c01, 0, 0]]).is_ok());
        for got in [[8, 0x3c00, 0, 0], [7, 0x3c02, 0, 0], [7, 0x7e00, 0, 0], [7, 0, 0x3c00, 0], [0; 4]] {
            assert!(same_planes(&want, &[got]).is_err(), "{got:x?}");
        }
        assert!(same_planes(&[], &[]).is_err());
        assert!(same_planes(&[Plane::default()], &[[0; 4]]).is_err());
    }

    #[test]
    fn same_requests_can_fail() {
        let map = |e: &[(u64, u32)]| e.iter().copied().collect::<BTreeMap<_, _>>();
        let want = Requests { pixels: map(&[(1, 50), (2, 50)]), entries: 2, near: vec![(1, [1, 3].into())] };
        for got in [map(&[(1, 50), (2, 50)]), map(&[(1, 49), (2, 50), (3, 1)])] {
            assert!(same_requests(&want, &got).is_ok(), "{got:?}");
        }
        let wrong: [&[(u64, u32)]; 6] = [
            &[],
            &[(1, 50)],
            &[(1, 49), (2, 51)],
            &[(1, 48), (2, 50), (3, 2)],
            &[(1, 49), (2, 50)],
            &[(1, 50), (2, 50), (3, 1)],
        ];
        for got in wrong {
            assert!(same_requests(&want, &map(got)).is_err(), "{got:?}");
        }
        assert!(same_requests(&Requests::default(), &map(&[])).is_err());
        let vague = Requests { near: vec![(1, [1, 2].into()); 20], ..want };
        assert!(same_requests(&vague, &vague.pixels).is_err());
    }

    /// A table as the GPU would leave it.
    fn table(a: &Allocation, s: &Service) -> Table {
        let keys: Vec<u64> = a.nodes.keys().copied().collect();
        let link = |key: u64| keys.iter().position(|&k| k == key).map_or(0, |i| i as u32 + 1);
        let node = |(&key, n): (&u64, &umbrage::twin::allocate::Node)| {
            let [cost, ranks, slot, marks] = n.words();
            Node {
                own: n.own as u32,
                below: n.below as u32,
                cost,
                ranks,
                parent: if key_level(key) == ROOT_LEVEL { 0 } else { link(key_ancestor(key, 1)) },
                page: a.pages.iter().position(|p| p.key == key).map_or(0, |i| i as u32 + 1),
                slot,
                marks,
                child: n.child.map(|c| if c == 0 { 0 } else { link(c) }),
            }
        };
        let page = |p: &umbrage::twin::allocate::Page| Page {
            key: words(p.key),
            node: link(p.key) - 1,
            slot: p.slot,
            dynamic_slot: p.dynamic_slot,
            draws: p.draws,
            ..Page::zeroed()
        };
        let used = a.used();
        let slot = |layer: u32| Slot { used: if used.contains(&layer) { 9 } else { 0 }, ..Slot::zeroed() };
        Table {
            counters: Counters {
                leaves: a.leaves.len() as u32,
                nodes: (a.nodes.len() - a.leaves.len()) as u32,
                shift: a.shift,
                threshold: a.threshold,
                draw_threshold: a.draw_threshold,
                draw_order: a.draw_order,
                draws_asked: a.draws_asked,
                deferred: s.deferred,
                starved: s.starved,
                pages: a.pages.len() as u32,
                hits: a.hits,
                stale: a.stale,
                requested: s.requested,
                refused: s.refused,
                ..Counters::zeroed()
            },
            nodes: a.nodes.iter().map(node).collect(),
            entries: keys.iter().map(|k| s.entries[k]).collect(),
            pages: a.pages.iter().map(page).collect(),
            slots: (0..4).map(slot).collect(),
            keys,
        }
    }

    #[test]
    fn same_table_can_fail() {
        let input = Input {
            requests: [(key_of(21, 0, [2, 3]), 9), (key_of(22, 6, [1, 1]), 4)].into(),
            directional: vec![0, 1],
            held: vec![(key_of(23, 0, [0, 0]), true), (key_of(23, 6, [0, 0]), false)],
            moving: [key_of(23, 0, [0, 0])].into(),
            draw_budget: 16,
        };
        let a = allocate(&input, &Config { atlas_bytes: 16 << 16, ..Config::new([64, 48]) });
        let s = a.serve(|_| true, 0);
        let right = table(&a, &s);
        assert_eq!(same_table(&a, &s, &right, 9), Ok(()));
        let changes: [fn(&mut Table); 26] = [
            |t| t.counters.failed = 1,
            |t| t.counters.threshold += 1,
            |t| t.counters.draw_threshold += 1,
            |t| t.counters.draw_order += 1,
            |t| t.counters.draws_asked += 1,
            |t| t.counters.deferred += 1,
            |t| t.counters.starved += 1,
            |t| t.counters.hits += 1,
            |t| t.counters.stale += 1,
            |t| t.counters.refused[21] += 1,
            |t| t.nodes[4].own += 1,
            |t| t.nodes[0].below += 1,
            |t| t.nodes[0].cost += 1 << 24,
            |t| t.nodes[0].ranks += 1 << 16,
            |t| t.nodes[0].slot ^= 1 << 31,
            |t| t.nodes[0].marks ^= 4,
            |t| t.nodes[4].parent = 1,
            |t| t.nodes.iter_mut().for_each(|n| n.child.swap(0, 3)),
            |t| t.pages.swap(0, 1),
            |t| t.pages[1].node = 0,
            |t| t.pages[1].slot += 1,
            |t| t.pages[1].dynamic_slot = 5,
            |t| t.pages[1].draws ^= 1,
            |t| t.slots[0].used = 0,
            |t| t.entries[4] ^= 1,
            |t| t.keys[4] = 0,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut wrong = right.clone();
            change(&mut wrong);
            assert!(same_table(&a, &s, &wrong, 9).is_err(), "change {i}");
        }
        assert!(same_table(&Allocation::default(), &Service::default(), &right, 9).is_err());
        assert!(same_table(&a, &s, &right, 0).is_err());
    }

    #[test]
    fn images_can_fail() {
        let want = [0.0, 1.0, 1.0, 0.0];
        assert!(same_image(&want, &want).is_ok());
        for got in [&[0.0, 1.0, 1.0, 1.0][..], &[0.0, 1.0, 1.0], &[], &[-0.0, 1.0, 1.0, 0.0]] {
            assert!(same_image(&want, got).is_err(), "{got:?}");
        }
        for image in [&[][..], &[0.0; 100], &[1.0; 100], &[0.0, f32::NAN], &[0.0, 1.0, 2.0]] {
            assert!(mixed(image).is_err() && same_image(image, image).is_err(), "{image:?}");
        }
    }
}
