//! Trees of tiles against plain algorithms, and the methods that refine them.

use crate::bench::{Bench, Lcg};
use crate::comparators::{mixed, same_image};
use crate::scenes;
use glam::DVec3;
use umbrage::gpu::structs::Region;
use umbrage::lab::stages_tree::{Rule, TreeFrame, TreeShape, TreeStage, fvsm, qvsm, tiled};
use umbrage::lab::{Lab, View};
use umbrage::methods::{MethodSpec, create};
use umbrage::scene::Scene;

const SIZE: [u32; 2] = [320, 180];
const NO_TILE: u32 = u32::MAX;

/// What decides about a region, from all of its entries.
fn measured(shape: &TreeShape, requests: &[u32], drop: f32, region: Region) -> Region {
    let (side, bins) = (1u32 << shape.levels, shape.bins());
    let levels = region.size.map(|s| shape.levels - s.ilog2());
    let mut out = Region { samples: [0; 4], ..region };
    let mut finer = [0; 2];
    for y in 0..region.size[1] {
        for x in 0..region.size[0] {
            let quarter = usize::from(2 * x + 1 > region.size[0]) + 2 * usize::from(2 * y + 1 > region.size[1]);
            for bin in 0..bins {
                let at = |axis: u32| {
                    let entry = (region.low[1] + y) * side + region.low[0] + x;
                    requests[((axis * bins + bin) * side * side + entry) as usize]
                };
                out.samples[quarter] += at(0);
                if shape.rule != Rule::Changed {
                    (0..2).filter(|&a| bin > levels[a]).for_each(|a| finer[a] += at(a as u32));
                }
            }
        }
    }
    let all: u32 = out.samples.iter().sum();
    let dropped = (drop * all as f32) as u32;
    let wanted = match shape.rule {
        Rule::Rectangles => u32::from(finer[0] > dropped) | u32::from(finer[1] > dropped) << 1,
        Rule::Squares => 3 * u32::from(finer[0].max(finer[1]) > dropped),
        Rule::Changed => 3 * u32::from(all > 0),
    };
    let possible = u32::from(region.size[0] > 1) | u32::from(region.size[1] > 1) << 1;
    out.splits = wanted & possible;
    out.unmet = wanted & !possible;
    out.priority = if shape.rule == Rule::Changed { all } else { finer[0].max(finer[1]) };
    out
}

/// Parts of a region that have samples.
fn parts(region: &Region) -> Vec<Region> {
    let size = [0, 1].map(|a| region.size[a] >> (region.splits >> a & 1));
    let part = |i: u32| {
        let seen = (0..4).any(|q| q & region.splits == i && region.samples[q as usize] > 0);
        let low = [region.low[0] + (i & 1) * size[0], region.low[1] + (i >> 1) * size[1]];
        (i & !region.splits == 0 && seen).then(|| Region { low, size, ..bytemuck::Zeroable::zeroed() })
    };
    (0..4).filter_map(part).collect()
}

/// The last list, measured, and what each round refused.
fn twin(shape: &TreeShape, requests: &[u32], drop: f32, rounds: u32) -> (Vec<Region>, Vec<u32>) {
    let measure = |region| measured(shape, requests, drop, region);
    let keeps = shape.rule != Rule::Changed;
    let mut list = vec![measure(Region { size: [1 << shape.levels; 2], ..bytemuck::Zeroable::zeroed() })];
    let mut refused = Vec::new();
    for _ in 0..rounds {
        let mut room = shape.tiles as usize - if keeps { list.len() } else { 0 };
        let mut order: Vec<usize> = (0..list.len()).filter(|&i| list[i].splits != 0).collect();
        order.sort_by_key(|&i| (std::cmp::Reverse(list[i].priority), i));
        let taken = order.iter().take_while(|&&i| {
            let cost = parts(&list[i]).len() - usize::from(keeps);
            let fits = cost <= room;
            room = room.saturating_sub(cost);
            fits
        });
        let split: Vec<usize> = taken.copied().collect();
        refused.push((order.len() - split.len()) as u32);
        let next = list.iter().enumerate().flat_map(|(i, region)| match split.contains(&i) {
            true => parts(region),
            false if keeps => vec![*region],
            false => Vec::new(),
        });
        list = next.map(measure).collect();
    }
    (list, refused)
}

/// A few clumps of samples that need fine texels, and some spread that need coarser ones.
fn clumps(shape: &TreeShape, seed: u64) -> Vec<u32> {
    let mut random = Lcg(seed);
    let (side, bins) = (1u32 << shape.levels, shape.bins());
    let mut requests = vec![0; shape.request_words() as usize];
    let mut add = |x: u32, y: u32, need: [u32; 2], count: u32| {
        for (axis, need) in need.into_iter().enumerate().take(if bins > 1 { 2 } else { 1 }) {
            requests[(((axis as u32 * bins) + need.min(bins - 1)) * side * side + y * side + x) as usize] += count;
        }
    };
    for _ in 0..6 {
        let (x, y) = (random.below(side), random.below(side));
        for _ in 0..20 {
            let near = |v: u32, random: &mut Lcg| (v + random.below(4)).min(side - 1);
            let need = [random.below(bins), random.below(bins)];
            add(near(x, &mut random), near(y, &mut random), need, 1 + random.below(50));
        }
    }
    for _ in 0..side * side / 4 {
        add(random.below(side), random.below(side), [random.below(bins) / 2, random.below(bins) / 3], 1);
    }
    requests
}

#[test]
fn trees_are_those_of_the_twin() {
    let lab = Bench::plain();
    let mut bounded = 0;
    for (levels, tiles, rule) in [
        (0, 1, Rule::Rectangles),
        (1, 4, Rule::Squares),
        (3, 64, Rule::Rectangles),
        (4, 255, Rule::Rectangles),
        (4, 40, Rule::Rectangles),
        (4, 257, Rule::Squares),
        (5, 700, Rule::Squares),
        (5, 33, Rule::Squares),
        (5, 1024, Rule::Changed),
        (4, 50, Rule::Changed),
        (6, 300, Rule::Rectangles),
    ] {
        let shape = TreeShape { levels, tiles, rule };
        let stage = TreeStage::new(&lab, shape).unwrap();
        for (seed, drop) in [(1, 0.0), (2, 0.05), (3, 0.3), (4, 0.0)] {
            let rounds = if drop > 0.0 && rule != Rule::Changed { 2 * levels } else { levels };
            let requests = clumps(&shape, seed);
            let (list, state) = stage.refine(&lab, &requests, drop, rounds).unwrap();
            let (want, refused) = twin(&shape, &requests, drop, rounds);
            let name = format!("{shape:?}, seed {seed}, drop {drop}");
            assert!(!want.is_empty() && want.len() <= tiles as usize, "{name}");
            assert_eq!(list, want, "{name}");
            assert_eq!(state.refused[..rounds as usize], refused, "{name}");
            bounded += u32::from(refused.iter().any(|&n| n > 0));
            if rule != Rule::Changed || refused.iter().all(|&n| n == 0) {
                partitions(&shape, &requests, &list).unwrap_or_else(|why| panic!("{name}: {why}"));
            }
        }
    }
    assert!(bounded > 8, "{bounded} cases met the bound");
}

/// Each entry that has samples lies in one region.
fn partitions(shape: &TreeShape, requests: &[u32], list: &[Region]) -> Result<(), String> {
    let side = 1 << shape.levels;
    let mut covered = vec![0; side * side];
    for region in list {
        for y in region.low[1]..region.low[1] + region.size[1] {
            (region.low[0]..region.low[0] + region.size[0]).for_each(|x| covered[y as usize * side + x as usize] += 1);
        }
    }
    for (entry, &count) in covered.iter().enumerate() {
        let seen = (0..shape.bins() as usize).any(|bin| requests[bin * side * side + entry] > 0);
        if count > 1 || seen && count == 0 {
            return Err(format!("entry {entry} lies in {count} regions, samples: {seen}"));
        }
    }
    Ok(())
}

#[test]
fn a_partition_with_a_gap_or_an_overlap_is_seen() {
    let shape = TreeShape { levels: 3, tiles: 64, rule: Rule::Rectangles };
    let requests = vec![1; shape.request_words() as usize];
    let (list, _) = twin(&shape, &requests, 0.0, 3);
    assert!(partitions(&shape, &requests, &list).is_ok() && list.len() == 64);
    assert!(partitions(&shape, &requests, &list[1..]).is_err());
    assert!(partitions(&shape, &requests, &[&list[..], &list[..1]].concat()).is_err());
}

/// Across the light and in [0, 1]^2 of the root.
fn in_root(frame: &TreeFrame, v: DVec3, point: bool) -> [f64; 2] {
    let t = [v.dot(frame.axes[0]), v.dot(frame.axes[1]), f64::from(u8::from(point))];
    [frame.root.row_u, frame.root.row_v].map(|row| (0..3).map(|i| f64::from(row[i]) * t[i]).sum())
}

/// What samples ask for, from positions and normals in double precision.
fn requests_of(lab: &Lab, frame: &TreeFrame, shape: &TreeShape, texels: f64, density: f64) -> Vec<u32> {
    let (gbuffer, side) = (lab.gbuffer().unwrap(), 1u32 << shape.levels);
    let forward = -lab.view().camera.view_from_world().row(2);
    let mut out = vec![0; shape.request_words() as usize];
    for i in (0..gbuffer.hit.len()).filter(|&i| gbuffer.hit[i]) {
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (p, n) = (vector(gbuffer.position[i]), vector(gbuffer.normal[i]));
        if n.dot(frame.axes[2]) >= 0.0 {
            continue;
        }
        let (depth, uv) = (forward.dot(p), in_root(frame, p, true));
        let mut extent = [0.0; 2];
        for step in gbuffer.ray_steps {
            // where the ray through the next pixel meets the plane, to the first order
            let moved = depth * (step - p * (n.dot(step) / n.dot(p)));
            let [u, v] = in_root(frame, moved, false).map(f64::abs);
            extent = [extent[0] + u, extent[1] + v];
        }
        let entry = uv.map(|u| ((u * f64::from(side)) as u32).min(side - 1));
        for (axis, extent) in extent.into_iter().enumerate() {
            let level = (density / (extent * texels)).log2().ceil().clamp(0.0, f64::from(shape.bins() - 1)) as u32;
            let bin = axis as u32 * shape.bins() + level;
            out[(bin * side * side + entry[1] * side + entry[0]) as usize] += 1;
        }
    }
    out
}

#[test]
fn requests_are_those_of_the_twin() {
    for (scene, view) in [scenes::long_row(SIZE), scenes::leaves(SIZE), scenes::random(SIZE, 7)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        for (keys, density, levels, tile) in
            [("density=1,levels=4,tile=64", 1.0, 4, 64.0), ("density=3,levels=6,tile=32", 3.0, 6, 32.0)]
        {
            let shape = TreeShape { levels, tiles: 256, rule: Rule::Rectangles };
            let frame = fvsm(&lab, &format!("fvsm:{keys}")).unwrap();
            let want = requests_of(&lab, &frame, &shape, tile - 2.0, density);
            let samples: u32 = want.iter().sum();
            // rounding moves a few samples to the next entry or level
            let differing: u32 = frame.requests.iter().zip(&want).map(|(a, b)| a.abs_diff(*b)).sum();
            println!("{name}, {keys}: {differing} of {samples} requests differ");
            assert!(samples > 10_000 && differing * 100 < samples, "{name}, {keys}: {differing} of {samples}");
            let doubled = requests_of(&lab, &frame, &shape, tile - 2.0, 1.5 * density);
            let differing: u32 = frame.requests.iter().zip(&doubled).map(|(a, b)| a.abs_diff(*b)).sum();
            assert!(differing * 5 > samples, "{name}: other requests differ in {differing} of {samples} only");
            // the tree that grew from them
            let requests = &frame.requests[..shape.request_words() as usize];
            assert_eq!(frame.regions, twin(&shape, requests, 0.0, levels).0, "{name}, {keys}");
            picks(&lab, &frame, levels);
        }
    }
}

/// Each sample has the tile that holds it.
fn picks(lab: &Lab, frame: &TreeFrame, levels: u32) {
    let gbuffer = lab.gbuffer().unwrap();
    for i in 0..gbuffer.hit.len() {
        let tile = frame.picked[i];
        if !gbuffer.hit[i] {
            assert_eq!(tile, NO_TILE);
            continue;
        }
        let n = DVec3::from(gbuffer.normal[i].map(f64::from));
        if n.dot(frame.axes[2]) > -1e-3 {
            continue;
        }
        let region = frame.regions[tile as usize];
        let uv = in_root(frame, DVec3::from(gbuffer.position[i].map(f64::from)), true);
        for ((uv, low), size) in uv.into_iter().zip(region.low).zip(region.size) {
            let at = uv * f64::from(1u32 << levels) - f64::from(low);
            assert!(at > -1e-3 && at < f64::from(size) + 1e-3, "pixel {i}: {at} of {region:?}");
        }
    }
}

fn counters(lab: &Lab, spec: &str) -> impl Fn(&str) -> u64 + use<> {
    let mut method = create(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    method.frame(lab).unwrap();
    let counters = method.statistics(lab).unwrap().counters;
    move |name| counters.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("no counter {name}")).1
}

/// Every tile has what its samples ask for, or is as small as there is; where the list is full, a counter says what is not served.
#[test]
fn fvsm_ends_where_its_tiles_have_what_they_ask_for() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let open = counters(&lab, "fvsm:tile=128,density=1,tiles=2048,levels=8");
    assert_eq!(["refused", "beyond", "outside", "dropped"].map(&open), [0; 4]);
    assert!(open("tiles") > 40);
    assert!(counters(&lab, "fvsm:tile=128,density=1,tiles=2048,levels=2")("beyond") > 0);
    let full = counters(&lab, "fvsm:tile=128,density=1,tiles=24,levels=8");
    assert!(full("refused") > 0 && full("tiles") > 20 && full("tiles") <= 24 && full("outside") == 0);
    let frame = fvsm(&lab, "fvsm:tile=128,density=1,tiles=2048,levels=8").unwrap();
    assert!(frame.regions.iter().all(|r| r.splits == 0 && r.unmet == 0));
    assert!(frame.regions.iter().any(|r| r.size[0] != r.size[1]), "tiles are squares");
    // a tenth of the requests may be dropped: what is left above a tile's own levels is no more than that
    let shape = TreeShape { levels: 8, tiles: 2048, rule: Rule::Rectangles };
    let dropping = fvsm(&lab, "fvsm:tile=128,density=1,tiles=2048,levels=8,drop=10").unwrap();
    assert!(dropping.regions.len() < frame.regions.len());
    for region in dropping.regions {
        let measured = measured(&shape, &dropping.requests, 0.0, region);
        assert!(measured.priority * 10 <= measured.samples.iter().sum::<u32>(), "{measured:?}");
    }
}

/// Under a low sun footprints are long along one axis, which squares must serve along both.
#[test]
fn rectangles_need_fewer_texels_than_squares_under_a_low_sun() {
    let (scene, view) = scenes::low_sun(SIZE);
    let lab = Bench::new(scene, view);
    let [rectangles, squares] = ["rect", "square"]
        .map(|split| counters(&lab, &format!("fvsm:tile=64,tiles=2048,levels=7,split={split}")))
        .map(|counter| (counter("texels"), counter("refused")));
    println!("{rectangles:?} and {squares:?} texels and tiles not split");
    assert!(rectangles.1 == 0 && squares.1 == 0 && rectangles.0 * 3 < squares.0 * 2);
}

/// What was split to the finest level is as if all of it had been, and what was not changed less than the threshold.
#[test]
fn qvsm_is_its_finest_grid_where_it_is_refined() {
    for (scene, view) in [scenes::thin_poles(SIZE), scenes::leaves(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let spec = "qvsm:tile=64,tiles=256,levels=4";
        let (frame, served) = qvsm(&lab, &format!("{spec},threshold=0")).unwrap();
        let (grid, all) = qvsm(&lab, &format!("{spec},start=4")).unwrap();
        assert_eq!(frame.state.refused, [0; 20], "{name}");
        let [refined, finest] = [&frame.visibility, &grid.visibility];
        mixed(refined).unwrap();
        let at_finest = (0..served.len()).filter(|&i| served[i] == 4);
        let differing = at_finest.clone().filter(|&i| refined[i] != finest[i]).count();
        let count = at_finest.count();
        println!(
            "{name}: {count} of {} samples refined to the finest level, {:?} tiles",
            served.len(),
            &frame.state.counts[..5]
        );
        assert!(count > 2000 && count < all.iter().filter(|&&round| round == 4).count(), "{name}: {count}");
        assert_eq!(differing, 0, "{name}");
        // what is left differs by features that neither of two levels saw
        let left = (0..refined.len()).filter(|&i| refined[i] != finest[i]).count();
        assert!(left * 500 < refined.len(), "{name}: {left} pixels differ from the finest grid");
        // a threshold spares tiles
        let (coarse, _) = qvsm(&lab, &format!("{spec},threshold=200")).unwrap();
        let drawn = |frame: &TreeFrame| frame.state.counts[1..5].iter().sum::<u32>();
        assert!(drawn(&coarse) < drawn(&frame) && frame.state.counts[4] < grid.state.counts[4], "{name}");
        assert!(same_image(&coarse.visibility, refined).is_err(), "{name}");
    }
}

/// No tile of the last list changed more than the threshold unless it is of the finest level, or a counter says so.
#[test]
fn qvsm_counts_what_it_has_no_room_for() {
    let (scene, view) = scenes::leaves(SIZE);
    let lab = Bench::new(scene, view);
    let open = counters(&lab, "qvsm:tile=64,tiles=256,levels=4");
    assert_eq!(["refused", "outside", "dropped"].map(&open), [0; 3]);
    let full = counters(&lab, "qvsm:tile=64,tiles=16,levels=4");
    assert!(full("refused") > 0 && full("outside") == 0 && full("tiles") < open("tiles"));
    let (frame, _) = qvsm(&lab, "qvsm:tile=64,tiles=256,levels=4,threshold=30").unwrap();
    assert!(frame.regions.iter().all(|r| r.size == [1, 1] && (r.unmet != 0) == (r.changed > 30)));
}

/// Where a list of slices is cut in two.
fn cut(slices: &[u32]) -> usize {
    let all: i64 = slices.iter().map(|&s| i64::from(s)).sum();
    let off = |end: usize| (all - 2 * slices[..end].iter().map(|&s| i64::from(s)).sum::<i64>()).abs();
    let mut end = 1.min(slices.len());
    while end + 1 < slices.len() && off(end + 1) <= off(end) {
        end += 1;
    }
    end
}

/// The cut is as near to a half as whole slices allow, and moves towards what becomes more important.
#[test]
fn cuts_follow_the_share_of_importance() {
    let mut random = Lcg(11);
    for _ in 0..2000 {
        let count = 2 + random.below(60) as usize;
        let mut slices: Vec<u32> = (0..count).map(|_| 1 + random.below(1000)).collect();
        let before = cut(&slices);
        let half = |end: usize| {
            let part: u32 = slices[..end].iter().sum();
            (2 * i64::from(part) - i64::from(slices.iter().sum::<u32>())).abs()
        };
        assert!((1..count).all(|end| half(before) <= half(end)), "{slices:?} is cut at {before}");
        let raised = random.below(count as u32) as usize;
        slices[raised] += random.below(3000);
        let after = cut(&slices);
        assert!(
            if raised < before { after <= before } else { after >= before },
            "{slices:?}: {before} to {after}, {raised}"
        );
    }
}

/// Regions by recursive cuts across the longer side.
fn cuts(frame: &TreeFrame, levels: u32, region: [u32; 4], rounds: u32) -> Vec<[u32; 4]> {
    if rounds == 0 {
        return vec![region];
    }
    let [x, y, width, height] = region;
    let extent = [0, 1].map(|a| f64::from(region[2 + a]) * f64::from(frame.root.texel[a]));
    let along_u = width > 1 && (extent[0] >= extent[1] || height <= 1);
    let at = |x: u32, y: u32| frame.requests[(y << levels | x) as usize];
    let slices: Vec<u32> = if along_u {
        (x..x + width).map(|u| (y..y + height).map(|v| at(u, v)).sum()).collect()
    } else {
        (y..y + height).map(|v| (x..x + width).map(|u| at(u, v)).sum()).collect()
    };
    let end = cut(&slices) as u32;
    let parts = if along_u {
        [[x, y, end, height], [x + end, y, width - end, height]]
    } else {
        [[x, y, width, end], [x, y + end, width, height - end]]
    };
    parts.into_iter().flat_map(|part| cuts(frame, levels, part, rounds - 1)).collect()
}

/// The tiles of `tiled` are those of recursive cuts, each sample lies in its own, and what is important has the smaller ones.
#[test]
fn tiled_cuts_are_those_of_the_twin() {
    for (scene, view) in [scenes::long_row(SIZE), scenes::leaves(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        for tiles in [1, 2, 16, 64] {
            let frame = tiled(&lab, &format!("tiled:tile=128,tiles={tiles}")).unwrap();
            let want = cuts(&frame, 7, [0, 0, 128, 128], u32::ilog2(tiles));
            let got: Vec<_> = frame.regions.iter().map(|r| [r.low[0], r.low[1], r.size[0], r.size[1]]).collect();
            assert_eq!(got, want, "{name}, {tiles} tiles");
            let shape = TreeShape { levels: 7, tiles, rule: Rule::Changed };
            partitions(&shape, &frame.requests, &frame.regions).unwrap_or_else(|why| panic!("{name}, {tiles}: {why}"));
            picks(&lab, &frame, 7);
            let area = |r: &Region| r.size[0] * r.size[1];
            let [least, most] = [frame.regions.iter().map(area).min(), frame.regions.iter().map(area).max()];
            assert!(tiles < 16 || least.unwrap() * 2 < most.unwrap(), "{name}: {least:?} to {most:?} entries");
        }
        let [hard, jumps] = ["0", "16"].map(|j| tiled(&lab, &format!("tiled:tile=128,jumps={j}")).unwrap().regions);
        assert!(hard != jumps, "{name}: jumps count for nothing");
    }
}

#[test]
fn frames_of_trees_are_the_same_bits() {
    let (scene, view): (Scene, View) = scenes::leaves(SIZE);
    let lab = Bench::new(scene, view);
    for spec in ["fvsm:tile=64,density=4,tiles=40", "qvsm:tile=64,tiles=12,threshold=0", "tiled:tile=128"] {
        let mut method = create(&MethodSpec::parse(spec).unwrap(), &lab).unwrap();
        let images = [0; 3].map(|_| {
            method.frame(&lab).unwrap();
            method.visibility(&lab, 0).unwrap()
        });
        mixed(&images[0]).unwrap();
        assert!(images[0] == images[1] && images[1] == images[2], "{spec}");
    }
}
