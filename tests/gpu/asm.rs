//! Adaptive shadow maps: the choice of pages against a plain one on the CPU, images against ray tracing, and what happens from
//! frame to frame.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_image;
use crate::{maps, scenes};
use glam::DVec3;
use std::collections::BTreeSet;
use umbrage::gpu::structs::{AsmCounts, AsmPush, Cell, TilePage};
use umbrage::lab::stages_asm::{AsmTree, choose};
use umbrage::lab::{Lab, LabError, View};
use umbrage::methods::{Method, MethodSpec, create};
use umbrage::scene::{Changes, Scene};
use umbrage::truth::compare;
use umbrage::{Camera, Light};

const SIZE: [u32; 2] = [320, 180];
const NO_PAGE: u32 = u32::MAX;
/// Depths of the pages that are always there, and of the finest, of the trees that tests give.
const DEPTHS: [u32; 2] = [1, 6];
const FRAME: u32 = 40;

/// Victims in the order in which they lose their tiles; as in `glsl/methods/asm_choose.comp`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Victim {
    Free,
    Unused(u32),
    Used(u32),
    Kept,
}

/// The plain choice: a look at everything for every page.
fn twin(tree: &AsmTree, push: AsmPush) -> AsmTree {
    let mut t = tree.clone();
    (t.counts.made, t.counts.evicted, t.counts.displaced, t.counts.waiting) = (0, 0, 0, 0);
    for _ in 0..2 * push.most {
        let profit = |tile: usize, quarter: usize| {
            let (page, benefit) = (&t.pages[tile], t.pages[tile].benefit[quarter]);
            let wanted = page.depth != NO_PAGE && page.depth < DEPTHS[1] && benefit >= push.threshold.max(1);
            let count = benefit as f32;
            let cost = 0.25 * page.texels[quarter] as f32 + push.overhead * count;
            (wanted && t.cells[tile].child[quarter] == 0).then(|| count * count / cost)
        };
        let offers = (0..4 * t.pages.len()).filter_map(|i| Some((profit(i / 4, i % 4)?, i)));
        let Some((_, offer)) = offers.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))) else { break };
        if t.counts.made >= push.most {
            t.counts.waiting = 1;
            break;
        }
        let victim = |tile: usize| {
            let page = &t.pages[tile];
            match page {
                _ if page.depth == NO_PAGE => Victim::Free,
                _ if page.parent == 0 || page.used == FRAME || t.cells[tile].child != [0; 4] => Victim::Kept,
                _ if page.used + 1 < FRAME => Victim::Unused(page.used),
                _ => Victim::Used(page.value),
            }
        };
        let (kind, tile) = (0..t.pages.len()).map(|tile| (victim(tile), tile)).min().unwrap();
        let (from, quarter) = (offer / 4, offer % 4);
        let gains = match kind {
            Victim::Kept => false,
            Victim::Used(value) => t.pages[from].benefit[quarter] as f32 > 1.25 * value as f32 + 1.0,
            _ => true,
        };
        if !gains || tile == from {
            t.pages[from].benefit[quarter] = 0;
            continue;
        }
        if kind == Victim::Free {
            t.counts.resident += 1;
        } else {
            t.counts.evicted += u32::from(matches!(kind, Victim::Unused(_)));
            t.counts.displaced += u32::from(matches!(kind, Victim::Used(_)));
            let parent = t.pages[tile].parent as usize - 1;
            t.cells[parent].child.iter_mut().filter(|c| **c == tile as u32 + 1).for_each(|c| *c = 0);
            t.pages[parent].used = t.pages[parent].used.max(t.pages[tile].used);
            t.pages[parent].value = t.pages[parent].value.max(t.pages[tile].value);
        }
        t.cells[from].child[quarter] = tile as u32 + 1;
        t.cells[tile] = Cell { child: [0; 4], tile: tile as u32 + 1 };
        let parent = t.pages[from];
        t.pages[tile] = TilePage {
            depth: parent.depth + 1,
            x: 2 * parent.x + (quarter as u32 & 1),
            y: 2 * parent.y + (quarter as u32 >> 1),
            parent: from as u32 + 1,
            used: FRAME,
            value: parent.benefit[quarter],
            ..TilePage::default()
        };
        t.drawn[tile] = 1;
        t.counts.made += 1;
    }
    t
}

/// A tree that grew at random, with random uses and wishes.
fn random_tree(lcg: &mut Lcg, tiles: usize, pages: usize) -> AsmTree {
    let free = TilePage { depth: NO_PAGE, ..TilePage::default() };
    let counts = AsmCounts { resident: 0, made: 0, evicted: 0, displaced: 0, waiting: 0, stale: 0 };
    let mut t =
        AsmTree { cells: vec![Cell::default(); tiles], pages: vec![free; tiles], drawn: vec![0; tiles], counts };
    let roots = 1usize << (2 * DEPTHS[0]);
    let side = 1usize << DEPTHS[0];
    for i in 0..roots {
        t.pages[i] = TilePage { depth: DEPTHS[0], x: (i % side) as u32, y: (i / side) as u32, ..TilePage::default() };
        t.cells[i].tile = i as u32 + 1;
    }
    let mut taken = roots;
    while taken < pages {
        let (from, quarter) = (lcg.below(taken as u32) as usize, lcg.below(4) as usize);
        let parent = t.pages[from];
        if parent.depth < DEPTHS[1] && t.cells[from].child[quarter] == 0 {
            t.cells[from].child[quarter] = taken as u32 + 1;
            t.cells[taken].tile = taken as u32 + 1;
            let (x, y) = (2 * parent.x + (quarter as u32 & 1), 2 * parent.y + (quarter as u32 >> 1));
            t.pages[taken] = TilePage { depth: parent.depth + 1, x, y, parent: from as u32 + 1, ..parent };
            taken += 1;
        }
    }
    for page in &mut t.pages[..taken] {
        page.used = [FRAME - 1, FRAME - 1 - lcg.below(6)][lcg.below(2) as usize];
        page.value = lcg.below(50);
        for quarter in 0..4 {
            if lcg.below(4) == 0 {
                page.benefit[quarter] = lcg.below(60);
                page.texels[quarter] = page.benefit[quarter] * (4 << (2 * lcg.below(4)));
            }
        }
    }
    t.counts.resident = taken as u32;
    t
}

/// No page is lost or has two tiles, parents and children know each other, and pages that are always there are there.
fn whole(tree: &AsmTree) {
    let pages: Vec<_> = tree.pages.iter().enumerate().filter(|(_, p)| p.depth != NO_PAGE).collect();
    let places: BTreeSet<_> = pages.iter().map(|(_, p)| (p.depth, p.x, p.y)).collect();
    assert_eq!(places.len(), pages.len(), "a page has two tiles");
    assert_eq!(pages.len(), tree.counts.resident as usize);
    let mut children = 0;
    for &(tile, page) in &pages {
        if page.depth == DEPTHS[0] {
            assert_eq!((page.parent, tile as u32), (0, (page.y << DEPTHS[0]) + page.x));
        } else {
            let parent = &tree.pages[page.parent as usize - 1];
            assert_eq!((parent.depth + 1, parent.x, parent.y), (page.depth, page.x >> 1, page.y >> 1));
            let quarter = ((page.x & 1) | (page.y & 1) << 1) as usize;
            assert_eq!(tree.cells[page.parent as usize - 1].child[quarter], tile as u32 + 1, "tile {tile} is lost");
        }
        children += tree.cells[tile].child.iter().filter(|c| **c != 0).count();
    }
    assert_eq!(children + (1 << (2 * DEPTHS[0])), pages.len(), "children that are no pages");
}

#[test]
fn choices_are_those_of_the_twin() {
    let lab = Bench::plain();
    let (mut made, mut evicted, mut displaced) = (0, 0, 0);
    for seed in 0..24 {
        let mut lcg = Lcg(seed);
        let tiles = [16, 60, 256, 260, 1000][lcg.below(5) as usize];
        let pages = [tiles, tiles, 4 + lcg.below(tiles as u32 - 4) as usize][lcg.below(3) as usize];
        let tree = random_tree(&mut lcg, tiles, pages);
        whole(&tree);
        let push = AsmPush {
            most: [1, 7, 16, 100][lcg.below(4) as usize],
            threshold: 1 + lcg.below(10),
            overhead: [0.0, 1.0, 20.0][lcg.below(3) as usize],
        };
        let (got, fits) = choose(&lab, &tree, DEPTHS, FRAME, push).unwrap();
        whole(&got);
        let want = twin(&tree, push);
        assert_eq!(got.counts, want.counts, "seed {seed}");
        assert_eq!(got, want, "seed {seed}");
        for (tile, fit) in fits.iter().enumerate().take(tiles) {
            assert_eq!(fit.texel[0] > 0.0, got.drawn[tile] == 1, "seed {seed}: tile {tile} is placed when it is drawn");
        }
        made += got.counts.made;
        evicted += got.counts.evicted;
        displaced += got.counts.displaced;
    }
    assert!(made > 200 && evicted > 50 && displaced > 20, "{made} made, {evicted} evicted, {displaced} displaced");
}

/// Pages that are not in use lose their tiles in the order of their last use, before any that is in use.
#[test]
fn the_least_recently_used_goes_first() {
    let lab = Bench::plain();
    let mut tree = random_tree(&mut Lcg(1), 8, 4);
    for (quarter, used) in [FRAME - 3, FRAME - 9, FRAME - 5, FRAME - 1].into_iter().enumerate() {
        let tile = 4 + quarter;
        tree.pages[tile] = TilePage { depth: 2, parent: 1, used, ..TilePage::default() };
        (tree.pages[tile].x, tree.pages[tile].y) = (quarter as u32 & 1, quarter as u32 >> 1);
        tree.cells[0].child[quarter] = tile as u32 + 1;
        tree.cells[tile].tile = tile as u32 + 1;
    }
    tree.pages[..4].iter_mut().for_each(|page| page.benefit = [0; 4]);
    (tree.pages[1].benefit, tree.pages[1].texels) = ([9, 8, 7, 6], [40; 4]);
    tree.counts.resident = 8;
    whole(&tree);
    for (most, order) in [(1, &[5][..]), (2, &[5, 6]), (3, &[5, 6, 4]), (4, &[5, 6, 4, 7])] {
        let push = AsmPush { most, threshold: 1, overhead: 1.0 };
        let (got, _) = choose(&lab, &tree, DEPTHS, FRAME, push).unwrap();
        let drawn: BTreeSet<usize> = (0..8).filter(|&tile| got.drawn[tile] == 1).collect();
        assert_eq!(drawn, order.iter().copied().collect(), "{most} pages");
        assert_eq!((got.counts.evicted, got.counts.displaced), (most.min(3), most.saturating_sub(3)), "{most} pages");
    }
}

fn method(lab: &Lab, spec: &str) -> Box<dyn Method> {
    create(&MethodSpec::parse(spec).unwrap(), lab).unwrap()
}

fn counter(method: &mut dyn Method, lab: &Lab, name: &str) -> u64 {
    let counters = method.statistics(lab).unwrap().counters;
    counters.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no counter {name}")).1
}

/// Frames until nothing more is made while all pixels have a turn.
fn settle(method: &mut dyn Method, lab: &Lab) -> u32 {
    let mut quiet = 0;
    for frame in 1..100 {
        method.frame(lab).unwrap();
        quiet = if counter(method, lab, "pages_deferred") == 0 { quiet + 1 } else { 0 };
        if quiet == 8 {
            return frame;
        }
    }
    panic!("pages are made for ever");
}

#[test]
fn settled_maps_match_the_reference() {
    for (scene, view) in [scenes::sphere_on_plane(SIZE), scenes::thin_poles(SIZE), scenes::leaves(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        for spec in ["asm", "asm:cell=64,sampling=1,cells=64", "asm:level=min_length"] {
            let mut method = method(&lab, spec);
            let frames = settle(&mut *method, &lab);
            let pages = counter(&mut *method, &lab, "pages_resident");
            println!("{name}, {spec}: {frames} frames, {pages} pages");
            maps::near_truth(&format!("{name}, {spec}"), &method.visibility(&lab, 0).unwrap(), &reference);
            assert_eq!(counter(&mut *method, &lab, "outside"), 0);
            assert_eq!(counter(&mut *method, &lab, "dropped"), 0);
        }
        for spec in ["asm_gpu", "asm_gpu:cell=64,start=1024"] {
            let mut method = method(&lab, spec);
            method.frame(&lab).unwrap();
            let [iterations, outstanding] =
                ["iterations", "requests_outstanding"].map(|name| counter(&mut *method, &lab, name));
            println!("{name}, {spec}: {iterations} iterations");
            assert!(outstanding == 0 && (1..8).contains(&iterations), "{name}, {spec}: {iterations} iterations");
            maps::near_truth(&format!("{name}, {spec}"), &method.visibility(&lab, 0).unwrap(), &reference);
        }
    }
}

/// From frame to frame the error falls, until nothing more is made; then nothing changes.
#[test]
fn quality_grows_until_it_is_enough() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    for (spec, full) in [("asm:cells=8", false), ("asm:cells=8,memory_mib=3", true)] {
        let mut method = method(&lab, spec);
        let mut errors = Vec::new();
        let mut resident = Vec::new();
        for _ in 0..24 {
            method.frame(&lab).unwrap();
            errors.push(compare(&method.visibility(&lab, 0).unwrap(), &reference).unwrap().mismatch);
            resident.push(counter(&mut *method, &lab, "pages_resident"));
        }
        println!("{spec}: {errors:.3?} % with {resident:?} pages");
        // a finer piece may err where a coarse one was right by chance: a few pixels
        let tolerance = 100.0 * 12.0 / f64::from(SIZE[0] * SIZE[1]);
        for pair in errors.windows(2) {
            assert!(pair[1] <= pair[0] + tolerance, "{spec}: {errors:?}");
        }
        assert!(errors[23] < 0.4 * errors[0], "{spec}: {errors:?}");
        let capacity = counter(&mut *method, &lab, "page_capacity");
        assert!(resident.windows(2).all(|pair| pair[0] <= pair[1]) && resident[23] <= capacity, "{spec}");
        assert_eq!(resident[23] == capacity, full, "{spec}: {resident:?} of {capacity}");
    }
}

fn shift(scene: &mut Scene, instance: usize, by: [f32; 3]) -> Changes {
    for (row, by) in scene.instances[instance].rows.iter_mut().zip(by) {
        row[3] += by;
    }
    Changes { instances: vec![instance as u32], ..Changes::default() }
}

/// Moves the second instance.
fn push_aside(lab: &mut Lab, by: [f32; 3]) {
    lab.edit(|scene| Ok::<_, LabError>(shift(scene, 1, by))).unwrap();
}

/// The frame in which a caster moves shows its shadow where it is then and not where it was.
#[test]
fn a_moved_caster_takes_its_shadow_along() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view);
    let mut method = method(&lab, "asm");
    settle(&mut *method, &lab);
    assert_eq!(counter(&mut *method, &lab, "pages_stale"), 0);
    let before = method.visibility(&lab, 0).unwrap();
    // a little, and so far that the shadow leaves its pages
    for by in [[0.25, 0.0, 0.1], [-0.6, 0.1, 0.0], [2.2, 0.0, -0.6]] {
        push_aside(&mut lab, by);
        let reference = lab.reference(0, &|_| {}).unwrap();
        // the old shadow would be seen
        assert!(compare(&before, &reference).unwrap().off_edge > 0.5);
        method.frame(&lab).unwrap();
        let stale = counter(&mut *method, &lab, "pages_stale");
        assert!(stale > 0 && stale < counter(&mut *method, &lab, "pages_resident"), "{stale} pages drawn again");
        let m = compare(&method.visibility(&lab, 0).unwrap(), &reference).unwrap();
        println!(
            "moved by {by:?}: {stale} pages drawn again, off_edge {:.3} %, edge_error {:.2} %",
            m.off_edge, m.edge_error
        );
        assert!(m.off_edge <= 0.2, "{m:?}");
        settle(&mut *method, &lab);
        maps::near_truth("moved", &method.visibility(&lab, 0).unwrap(), &reference);
        assert_eq!(counter(&mut *method, &lab, "pages_stale"), 0);
    }
}

/// What a page holds depends on where it lies and on the casters, not on when it was drawn: with every caster said to be
/// changed, all pages are drawn again, and the image stays.
#[test]
fn pages_drawn_again_are_the_same() {
    let (scene, view) = scenes::leaves(SIZE);
    let mut lab = Bench::new(scene, view);
    let mut method = method(&lab, "asm");
    settle(&mut *method, &lab);
    let before = method.visibility(&lab, 0).unwrap();
    let resident = counter(&mut *method, &lab, "pages_resident");
    let all = |scene: &mut Scene| {
        scene.instances.iter_mut().for_each(|instance| instance.revision += 1);
        Ok::<_, LabError>(Changes { instances: (0..scene.instances.len() as u32).collect(), ..Changes::default() })
    };
    lab.edit(all).unwrap();
    method.frame(&lab).unwrap();
    let stale = counter(&mut *method, &lab, "pages_stale");
    assert!(stale > 16 && stale <= resident, "{stale} of {resident}");
    same_image(&method.visibility(&lab, 0).unwrap(), &before).unwrap();
}

fn turned(view: &View, share: f64) -> View {
    let camera = view.camera;
    let aim = camera.target - camera.eye;
    let aside = aim.cross(DVec3::Y);
    View { camera: Camera { target: camera.target + share * aside, ..camera }, ..view.clone() }
}

/// Pages stay while the camera moves, also while it looks elsewhere; another light starts anew.
#[test]
fn pages_are_kept_until_the_light_changes() {
    let (scene, view) = scenes::leaves(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut method = method(&lab, "asm:cells=64,sampling=1");
    settle(&mut *method, &lab);
    let image = method.visibility(&lab, 0).unwrap();
    let kept = counter(&mut *method, &lab, "pages_resident");
    lab.look(turned(&view, 0.12)).unwrap();
    settle(&mut *method, &lab);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let m = compare(&method.visibility(&lab, 0).unwrap(), &reference).unwrap();
    assert!(m.edge_pixels > 100 && m.edge_error < 4.0 && m.off_edge < 0.1, "turned: {m:?}");
    assert!(counter(&mut *method, &lab, "pages_resident") >= kept);
    lab.look(view.clone()).unwrap();
    method.frame(&lab).unwrap();
    assert_eq!(counter(&mut *method, &lab, "pages_made"), 0, "pages of an earlier view were lost");
    same_image(&method.visibility(&lab, 0).unwrap(), &image).unwrap();
    let sun = Light::directional(DVec3::new(-0.3, -1.0, 0.4));
    lab.look(View { lights: vec![sun], ..view }).unwrap();
    method.frame(&lab).unwrap();
    let [resident, made] = ["pages_resident", "pages_made"].map(|name| counter(&mut *method, &lab, name));
    assert_eq!(resident, 16 + made, "pages of another light are kept");
    settle(&mut *method, &lab);
    let reference = lab.reference(0, &|_| {}).unwrap();
    maps::near_truth("another sun", &method.visibility(&lab, 0).unwrap(), &reference);
}

/// The eye moves by less than a texel at a time, and by much: pages drawn from one place serve from another.
#[test]
fn pages_do_not_move_with_the_eye() {
    let (scene, view) = scenes::thin_poles(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut method = method(&lab, "asm");
    settle(&mut *method, &lab);
    for step in [1e-4, 0.01, 0.3, -0.7] {
        let mut moved = view.clone();
        moved.camera.eye += DVec3::new(step, 0.5 * step, -step);
        lab.look(moved).unwrap();
        settle(&mut *method, &lab);
        let reference = lab.reference(0, &|_| {}).unwrap();
        maps::near_truth(&format!("moved by {step}"), &method.visibility(&lab, 0).unwrap(), &reference);
    }
}

/// A full map serves new views: what is not in use gives way.
#[test]
fn a_full_map_gives_tiles_to_what_is_seen() {
    let (scene, view) = scenes::street(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut method = method(&lab, "asm:memory_mib=4,sampling=1");
    settle(&mut *method, &lab);
    let capacity = counter(&mut *method, &lab, "page_capacity");
    let mut evicted = 0;
    for share in [0.5, -0.3, 0.0] {
        lab.look(turned(&view, share)).unwrap();
        for _ in 0..12 {
            method.frame(&lab).unwrap();
            evicted += counter(&mut *method, &lab, "pages_evicted");
            assert!(counter(&mut *method, &lab, "pages_resident") <= capacity);
        }
        let reference = lab.reference(0, &|_| {}).unwrap();
        let m = compare(&method.visibility(&lab, 0).unwrap(), &reference).unwrap();
        println!(
            "turned by {share}: edge_error {:.2} %, off_edge {:.3} %, {evicted} evicted",
            m.edge_error, m.off_edge
        );
        assert!(m.edge_error < 12.0 && m.off_edge < 0.3, "{m:?}");
    }
    assert!(evicted > 8, "{evicted} evicted");
}

#[test]
fn two_runs_are_the_same() {
    let (scene, view) = scenes::leaves(SIZE);
    let run = |spec: &str| {
        let lab = Bench::new(scene.clone(), view.clone());
        let mut method = method(&lab, spec);
        let frames = (0..6).map(|_| {
            method.frame(&lab).unwrap();
            (method.visibility(&lab, 0).unwrap(), method.statistics(&lab).unwrap())
        });
        frames.collect::<Vec<_>>()
    };
    for spec in ["asm:memory_mib=3", "asm_gpu:memory_mib=3"] {
        let [first, second] = [run(spec), run(spec)];
        for (frame, (a, b)) in first.iter().zip(&second).enumerate() {
            same_image(&a.0, &b.0).unwrap_or_else(|why| panic!("{spec}, frame {frame}: {why}"));
            assert_eq!(a.1, b.1, "{spec}, frame {frame}");
        }
        assert_eq!(spec.starts_with("asm:"), same_image(&first[0].0, &first[5].0).is_err(), "{spec}");
    }
}

/// Without room or iterations for all pages, what is missing is counted.
#[test]
fn what_is_missing_is_counted() {
    let (scene, view) = scenes::leaves(SIZE);
    let lab = Bench::new(scene, view);
    let all = |spec: &str| {
        let mut method = method(&lab, spec);
        method.frame(&lab).unwrap();
        ["pages_resident", "page_capacity", "requests_outstanding", "iterations"]
            .map(|name| counter(&mut *method, &lab, name))
    };
    let [enough, capacity, outstanding, needed] = all("asm_gpu");
    assert!(outstanding == 0 && enough < capacity && needed >= 2, "{needed} iterations, {enough} pages");
    let [resident, capacity, outstanding, _] = all("asm_gpu:memory_mib=2");
    assert!(resident == capacity && outstanding > 0 && outstanding < enough, "{outstanding} of {enough}");
    let [_, _, outstanding, iterations] = all("asm_gpu:iterations=1");
    assert!(iterations == 1 && outstanding > 0, "{outstanding} after one of {needed} iterations");
}

/// 16 MiB reach the thesis's 65,536 texels along a side, and 524,288, from close by.
#[test]
fn close_views_reach_large_maps() {
    let (scene, mut view) = scenes::street(SIZE);
    let (target, aim) = (DVec3::new(1.7504, -0.0186, 6.4449), DVec3::new(1.945, 0.0832, 6.6006));
    for (distance, least) in [(1.0, 65_536.0), (0.1, 524_288.0)] {
        view.camera = Camera { eye: target + distance * (aim - target), target, near: 0.001, ..view.camera };
        view.lights = vec![Light::directional(DVec3::new(0.32, -0.7, 0.63))];
        let lab = Bench::new(scene.clone(), view.clone());
        let mut method = method(&lab, "asm:cells=64");
        settle(&mut *method, &lab);
        let reached = method.statistics(&lab).unwrap().effective_resolution;
        let tiles = method.memory().iter().find(|(name, _)| *name == "map").unwrap().1;
        println!("{distance}: {reached:.0} texels along a side in {tiles} bytes");
        assert!(reached >= least && tiles <= 16 << 20, "{reached}");
    }
}
