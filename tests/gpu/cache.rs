//! What is kept from frame to frame: after any history a frame shows what a first frame would, within its budgets.

use crate::bench::{Bench, Lcg};
use crate::scenes;
use glam::{DQuat, DVec3};
use std::collections::BTreeSet;
use umbrage::CastPolicy;
use umbrage::gpu::structs::Page;
use umbrage::lab::stages::{EngineStage, Kept, Table};
use umbrage::lab::{LabError, View};
use umbrage::scene::{Changes, Motion, Scene};
use umbrage::truth::compare;
use umbrage::twin::key::{from_words, key_ancestor, key_level, key_page};
use umbrage::{Camera, Config, Light, LightId, Pressure};

const SIZE: [u32; 2] = [160, 90];
const STATIC: u32 = 2;
const DYNAMIC: u32 = 3;

/// 64 pages of 64^2 texels, all of which may be drawn in one frame.
fn small() -> Config {
    Config {
        atlas_bytes: 64 * 4 * 64 * 64,
        page_texels: 64,
        page_table_bytes: Config::table_bytes(1 << 11),
        pages_per_frame: 4096,
        sun_pages_per_frame: 4096,
        level_bias: -1.0,
        still_frames: 3,
        ..Config::new(SIZE)
    }
}

/// A scene with moving knots, and an engine that keeps its pages beside one that forgets them.
struct Play {
    lab: Bench,
    config: Config,
    cached: EngineStage,
    cold: EngineStage,
    still: Scene,
    base: View,
    lcg: Lcg,
    time_s: f64,
    /// Lights that the test itself adds, moves and removes; without them both engines have those of the view.
    lit: Option<Vec<LightId>>,
    /// Ids that are no more.
    gone: Vec<LightId>,
}

/// What a frame of both engines left.
struct Shown {
    table: Table,
    kept: Kept,
    cached: Vec<f32>,
    cold: Vec<f32>,
    /// Neither put anything off, so both must show the same.
    whole: bool,
}

impl Play {
    fn new(seed: u64, config: Config) -> Self {
        let (mut scene, base) = scenes::random(SIZE, seed);
        let motion = Motion::synthetic(&mut scene, base.camera.eye, base.camera.target, 2, seed);
        let still = scene.clone();
        let mut lab = Bench::new(scene, base.clone());
        lab.set_motion(motion);
        let cached = EngineStage::new(&lab, &config).unwrap();
        let cold = EngineStage::new(&lab, &Config { cache: false, ..config.clone() }).unwrap();
        let lcg = Lcg(seed ^ 0x5eed);
        Self { lab, config, cached, cold, still, base, lcg, time_s: 0.0, lit: None, gone: Vec::new() }
    }

    /// With lights at random instead of those of the view.
    pub fn lit(seed: u64, config: Config) -> Self {
        let mut play = Self::new(seed, config);
        play.cached = EngineStage::bare(&play.lab, &play.config).unwrap();
        play.cold = EngineStage::bare(&play.lab, &Config { cache: false, ..play.config.clone() }).unwrap();
        play.lit = Some(Vec::new());
        play.add_light();
        play.add_light();
        play
    }

    fn random_light(&mut self) -> Light {
        let lcg = &mut self.lcg;
        let position = DVec3::new(lcg.between(-4.0, 4.0), lcg.between(0.3, 4.0), lcg.between(-4.0, 4.0));
        let direction = DVec3::new(lcg.between(-0.8, 0.8), -1.0, lcg.between(-0.8, 0.8));
        let range = lcg.between(2.0, 12.0);
        match lcg.below(4) {
            0 => Light::directional(direction),
            1 => Light::Point { position, range },
            n => {
                let outer_angle_deg = if n == 2 { lcg.between(10.0, 60.0) } else { lcg.between(61.0, 90.0) };
                Light::Spot { position, direction, inner_angle_deg: 0.0, outer_angle_deg, range }
            }
        }
    }

    pub fn engines(&mut self) -> [&mut umbrage::Engine; 2] {
        [self.cached.engine(), self.cold.engine()]
    }

    fn add_light(&mut self) -> &'static str {
        let (light, capacity) = (self.random_light(), self.config.lights as usize);
        let [id, other] = self.engines().map(|engine| engine.add_light(&light));
        let Some(lit) = &mut self.lit else { return "nothing" };
        if lit.len() == capacity {
            assert!(id.is_err() && other.is_err(), "one light too many");
            return "one light too many";
        }
        let id = id.unwrap();
        assert_eq!(id, other.unwrap());
        assert!(!self.gone.contains(&id) && !lit.contains(&id), "{id:?} twice");
        lit.push(id);
        "add a light"
    }

    /// Something that happens to a light.
    fn light_step(&mut self) -> &'static str {
        let Some(count @ 1..) = self.lit.as_ref().map(Vec::len) else { return self.add_light() };
        let which = self.lcg.below(count as u32) as usize;
        let id = self.lit.as_ref().unwrap()[which];
        for &old in &self.gone.clone() {
            for engine in self.engines() {
                assert!(engine.remove_light(old).is_err(), "{old:?} was removed");
                assert!(engine.set_light(old, &Light::directional(DVec3::NEG_Y)).is_err(), "{old:?} was removed");
            }
        }
        match self.lcg.below(4) {
            0 => self.add_light(),
            1 => {
                self.engines().into_iter().for_each(|engine| engine.remove_light(id).unwrap());
                self.lit.as_mut().unwrap().remove(which);
                self.gone.push(id);
                "remove a light"
            }
            2 => {
                let light = self.random_light();
                self.engines().into_iter().for_each(|engine| engine.set_light(id, &light).unwrap());
                "change a light"
            }
            _ => {
                let light = self.random_light();
                self.engines().into_iter().for_each(|engine| engine.remove_light(id).unwrap());
                let ids = self.engines().map(|engine| engine.add_light(&light).unwrap());
                self.gone.push(id);
                assert!(ids[0] == ids[1] && !self.gone.contains(&ids[0]));
                self.lit.as_mut().unwrap()[which] = ids[0];
                "replace a light"
            }
        }
    }

    fn frame(&mut self) -> Shown {
        let (cached, table) = self.cached.all(&self.lab).unwrap();
        let (cold, cold_table) = self.cold.all(&self.lab).unwrap();
        // a layer without a light means nothing
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let slots: Vec<u32> = self.lit.as_ref().map_or(vec![0], |ids| ids.iter().map(LightId::slot).collect());
        let layers = |words: Vec<u32>| -> Vec<f32> {
            let layer =
                |&slot: &u32| words[slot as usize * pixels..][..pixels].iter().map(|&word| f32::from_bits(word));
            slots.iter().flat_map(layer).collect()
        };
        let (cached, cold) = (layers(cached), layers(cold));
        let kept = self.cached.kept(&self.lab).unwrap();
        let whole = [&table, &cold_table].iter().all(|t| t.counters.deferred == 0 && t.counters.draw_threshold == 0);
        Shown { table, kept, cached, cold, whole }
    }

    fn camera(&mut self, change: impl FnOnce(&mut Camera)) {
        let mut view = self.lab.view().clone();
        change(&mut view.camera);
        self.lab.look(view).unwrap();
    }

    fn animate(&mut self) {
        self.time_s += 1.0 / 30.0;
        self.lab.animate(self.time_s).unwrap();
    }

    /// Changes instance `i`, with another revision if `told`.
    fn instance(&mut self, i: usize, told: bool, change: impl FnOnce(&mut umbrage::scene::Instance)) {
        let edit = |scene: &mut Scene| {
            let instance = &mut scene.instances[i];
            change(instance);
            instance.revision += u32::from(told);
            Ok::<_, LabError>(Changes { instances: vec![i as u32], ..Changes::default() })
        };
        self.lab.edit(edit).unwrap();
    }

    /// Moves the vertices of a mesh a little towards the middle of its bounds and back.
    fn deform(&mut self, mesh: usize, share: f32) {
        let still = &self.still;
        let edit = |scene: &mut Scene| {
            let m = still.meshes[mesh];
            let indices = &still.indices[m.first_index as usize..][..m.index_count as usize];
            let vertices: BTreeSet<u32> = indices.iter().copied().collect();
            let (center, _) = umbrage::scene::mesh_bounds(still, &m);
            for &v in &vertices {
                let p = still.positions[v as usize];
                scene.positions[v as usize] = std::array::from_fn(|c| p[c] + (center[c] - p[c]) * share);
            }
            let clusters = m.first_cluster..m.first_cluster + m.cluster_count;
            for c in clusters.clone() {
                // the old bounds and the middle hold every vertex on the way
                let cluster = &mut scene.clusters[c as usize];
                let old = still.clusters[c as usize];
                for (axis, middle) in center.iter().enumerate() {
                    let low = (old.center[axis] - old.extent[axis]).min(*middle);
                    let high = (old.center[axis] + old.extent[axis]).max(*middle);
                    cluster.center[axis] = 0.5 * (low + high);
                    cluster.extent[axis] = (0.5 * (high - low)) * 1.000_001 + 1e-6;
                }
            }
            let (low, high) = (*vertices.first().unwrap(), *vertices.last().unwrap());
            let instances: Vec<u32> = (m.first_instance..m.first_instance + m.instance_count).collect();
            for &i in &instances {
                scene.instances[i as usize].revision += 1;
            }
            let mut changes = Changes { instances, meshes: vec![mesh as u32], ..Changes::default() };
            changes.vertices.push(low..high + 1);
            changes.clusters.push(clusters);
            Ok::<_, LabError>(changes)
        };
        self.lab.edit(edit).unwrap();
    }

    /// Something that happens between two frames.
    fn step(&mut self) -> &'static str {
        let casters = self.still.instances.len() as u32;
        let which = self.lcg.below(casters) as usize;
        let [a, b, c] = std::array::from_fn(|_| self.lcg.between(-1.0, 1.0));
        let base = self.base.camera;
        match self.lcg.below(if self.lit.is_some() { 20 } else { 14 }) {
            0 => "still",
            1 => {
                self.camera(|camera| camera.target += 0.005 * DVec3::new(a, b, c));
                "jitter"
            }
            2 => {
                self.camera(|camera| camera.eye += 0.3 * DVec3::new(a, 0.3 * b, c));
                "walk"
            }
            3 => {
                let turn = DQuat::from_rotation_y(0.3 * a);
                self.camera(|camera| camera.target = camera.eye + turn * (camera.target - camera.eye));
                "turn"
            }
            4 => {
                self.camera(|camera| *camera = Camera { eye: base.eye + 3.0 * DVec3::new(a, 0.3 * b, c), ..base });
                "teleport"
            }
            5 => {
                self.camera(|camera| camera.fov_y_deg = 30.0 + 25.0 * a);
                "zoom"
            }
            6..=8 => {
                self.animate();
                "animate"
            }
            9 | 10 => {
                // the revision is not needed where the matrix tells
                let rows = self.still.instances[which].rows;
                let delta = [0.4 * a, 0.2 * (b + 1.0), 0.4 * c];
                self.instance(which, b > 0.0, |instance| {
                    for (axis, d) in delta.iter().enumerate() {
                        instance.rows[axis][3] = rows[axis][3] + *d as f32;
                    }
                });
                "move"
            }
            11 => {
                let never = CastPolicy::Never as u32;
                self.instance(which, false, |i| i.flags = i.flags & !3 | if i.flags & 3 == never { 0 } else { never });
                "appear or disappear"
            }
            12 => {
                let policy = [CastPolicy::Auto, CastPolicy::Static, CastPolicy::Always][self.lcg.below(3) as usize];
                self.instance(which, false, |i| i.flags = i.flags & !3 | policy as u32);
                "policy"
            }
            14.. => self.light_step(),
            _ => {
                self.deform(self.still.instances[which].mesh as usize, (0.4 * (a + 1.0)) as f32);
                "deform"
            }
        }
    }
}

/// No page has two layers or two pages one, every entry points to its own address, nothing exceeds its budget.
fn invariants(config: &Config, table: &Table, kept: &Kept) -> Result<(), String> {
    let ensure = |ok: bool, what: &dyn Fn() -> String| if ok { Ok(()) } else { Err(what()) };
    let c = &table.counters;
    let capacity = config.page_capacity();
    let keys: Vec<u64> = kept.slots.iter().map(|s| from_words(s.key)).filter(|k| *k != 0).collect();
    let distinct: BTreeSet<u64> = keys.iter().copied().collect();
    ensure(distinct.len() == keys.len(), &|| format!("a page has two layers: {keys:x?}"))?;
    let order: BTreeSet<u32> = kept.order.iter().copied().collect();
    ensure(order.len() as u32 == capacity && order.last() == Some(&(capacity - 1)), &|| {
        format!("the order of eviction is no permutation: {:?}", kept.order)
    })?;
    let mut layers = BTreeSet::new();
    for page in table.pages.iter().filter(|p| p.admitted == 1) {
        let slot = kept.slots.get(page.slot as usize);
        ensure(slot.is_some_and(|s| s.key == page.key && s.valid == 1), &|| format!("{page:x?} lies in {slot:x?}"))?;
        ensure(layers.insert(page.slot), &|| format!("{page:x?} shares its layer"))?;
        if page.dynamic_slot != u32::MAX {
            let slot = kept.slots.get(page.dynamic_slot as usize);
            ensure(slot.is_some_and(|s| s.key == [0; 2]), &|| format!("moving casters of {page:x?} lie in {slot:x?}"))?;
            ensure(layers.insert(page.dynamic_slot), &|| format!("{page:x?} shares its second layer"))?;
        }
    }
    for (&key, &entry) in table.keys.iter().zip(&table.entries).filter(|(key, _)| **key != 0) {
        if entry == 0 {
            ensure(c.starved > 0, &|| format!("{key:x} has no entry"))?;
            continue;
        }
        ensure(entry >> 31 == 1, &|| format!("{key:x} has the entry {entry:x}"))?;
        let serving = key_ancestor(key, ((entry >> 26 & 31) as i32 - key_level(key)) as u32);
        let slot = kept.slots[(entry & 0xfff) as usize];
        ensure(from_words(slot.key) == serving && slot.valid == 1, &|| {
            format!("{key:x} is served by {slot:x?}, not {serving:x}")
        })?;
        let moving = table.pages.iter().find(|p| from_words(p.key) == serving && p.dynamic_slot != u32::MAX);
        let layer = moving.map_or(0, |p| p.dynamic_slot + 1);
        ensure(entry >> 12 & 0xfff == layer, &|| format!("{key:x}: entry {entry:x}, moving casters in {moving:x?}"))?;
    }
    let budgets = [
        ("layers", c.pages + c.drawn_dynamic, capacity),
        ("layers drawn", c.drawn + c.drawn_dynamic, config.pages_per_frame),
        ("pairs", c.pairs_opaque + c.pairs_masked, config.pair_capacity),
        ("nodes", c.leaves + c.nodes, 4 * config.request_capacity()),
        ("requests", c.leaves, config.request_capacity()),
        ("changed bounds", c.changed, 2 * kept.tracked.len() as u32),
    ];
    for (what, used, most) in budgets {
        ensure(used <= most, &|| format!("{used} {what}, the budget is {most}: {c:?}"))?;
    }
    Ok(())
}

fn same(shown: &Shown) -> Result<(), String> {
    let differ = shown.cached.iter().zip(&shown.cold).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    if differ == 0 { Ok(()) } else { Err(format!("{differ} pixels differ from a cold frame's")) }
}

/// Plays `frames` frames; returns how many put something off.
fn play(seed: u64, config: Config, frames: u32) -> u32 {
    play_on(Play::new(seed, config), seed, frames)
}

fn play_on(mut play: Play, seed: u64, frames: u32) -> u32 {
    let (mut put_off, mut hits, mut moving, mut shadows) = (0, 0, 0, 0);
    for number in 0..frames {
        let what = if number == 0 { "the first frame" } else { play.step() };
        let shown = play.frame();
        let c = &shown.table.counters;
        let fail = |why| panic!("seed {seed}, frame {number} ({what}): {why}");
        invariants(&play.config, &shown.table, &shown.kept).unwrap_or_else(fail);
        if shown.whole {
            same(&shown).unwrap_or_else(fail);
        } else {
            assert!(c.deferred > 0, "seed {seed}, frame {number}: put off and not counted: {c:?}");
            put_off += 1;
        }
        hits += u32::from(c.hits > 0);
        moving += u32::from(c.drawn_dynamic > 0);
        shadows += u32::from(shown.cached.contains(&0.0) && shown.cached.contains(&1.0));
    }
    assert!(hits > frames / 2 && moving > frames / 8 && shadows > frames / 2, "{hits} {moving} {shadows}");
    put_off
}

#[test]
fn after_any_history_a_frame_is_that_of_a_cold_engine() {
    for seed in [1, 2] {
        assert_eq!(play(seed, small(), 150), 0, "nothing is put off without a limit of pages");
    }
}

/// The tree for rays follows what moves, deforms, appears and disappears.
#[test]
fn exact_frames_follow_what_moves() {
    let seed = 21;
    let mut play = Play::new(seed, Config { exact: true, ..small() });
    let mut edges = 0;
    for number in 0..60 {
        let what = if number == 0 { "the first frame" } else { play.step() };
        let shown = play.frame();
        same(&shown).unwrap_or_else(|why| panic!("seed {seed}, frame {number} ({what}): {why}"));
        let m = compare(&shown.cached, &play.lab.reference(0, &|_| {}).unwrap()).unwrap();
        assert!(m.mismatch <= 0.1 && m.off_edge <= 0.05, "seed {seed}, frame {number} ({what}): {m:?}");
        edges += m.edge_pixels;
    }
    assert!(edges > 60 * 100, "{edges} edge pixels");
}

/// Lights come, change and go as well.
#[test]
fn after_any_history_of_lights_a_frame_is_that_of_a_cold_engine() {
    for (seed, lights) in [(31, 3), (32, 6), (33, 1)] {
        let config = Config { lights, drift_texels: 0.0, atlas_bytes: 128 * 4 * 64 * 64, ..small() };
        assert_eq!(play_on(Play::lit(seed, config), seed, 120), 0, "nothing is put off without a limit of pages");
    }
}

#[test]
fn a_budget_of_pages_holds_and_what_it_puts_off_is_counted() {
    let put_off = play(3, Config { pages_per_frame: 16, ..small() }, 120);
    assert!((10..110).contains(&put_off), "{put_off} of 120 frames put something off");
}

/// The street holds still: the second frame draws nothing, whatever the camera does within the pages at hand.
#[test]
fn nothing_that_is_right_is_drawn_again() {
    let mut play = Play::new(5, small());
    let first = play.frame();
    assert!(first.table.counters.drawn > 4 && first.table.counters.hits == 0, "{:?}", first.table.counters);
    let again = play.frame();
    let c = &again.table.counters;
    assert_eq!((c.drawn, c.drawn_dynamic, c.pairs_asked, c.evicted), (0, 0, 0, 0), "{c:?}");
    assert_eq!(again.cached, first.cached, "no pixel changes on a static view");
    // away and back: the pages are still there where the atlas has room
    let mut roomy = Play::new(5, Config { atlas_bytes: 1024 * 4 * 64 * 64, ..small() });
    let before = roomy.frame();
    roomy.camera(|camera| camera.target = camera.eye + DQuat::from_rotation_y(2.0) * (camera.target - camera.eye));
    assert!(roomy.frame().table.counters.drawn > 0);
    roomy.lab.look(roomy.base.clone()).unwrap();
    let back = roomy.frame();
    assert_eq!((back.table.counters.drawn, &back.cached), (0, &before.cached));
}

/// What a mover touches is drawn in the second layer; the cached layer is drawn once when it starts and once when it stands.
#[test]
fn a_mover_redraws_only_its_own_layer() {
    let mut play = Play::new(7, small());
    play.frame();
    let state = |shown: &Shown| shown.kept.tracked.iter().filter(|t| t.state == DYNAMIC).count();
    play.animate();
    let started = play.frame();
    assert!(state(&started) == 2 && started.table.counters.stale > 0, "{:?}", started.table.counters);
    for _ in 0..5 {
        play.animate();
        let moving = play.frame();
        let c = &moving.table.counters;
        assert!(c.drawn_dynamic > 0 && c.stale == 0 && c.invalidated == 0, "{c:?}");
        same(&moving).unwrap();
    }
    // three frames later it is cached again
    for still in 1..=4 {
        let shown = play.frame();
        assert_eq!(state(&shown) > 0, still < 3, "{still} still frames");
        assert_eq!(shown.table.counters.invalidated > 0, still == 3, "{still} still frames");
        assert!(shown.kept.tracked.iter().all(|t| t.state >= STATIC));
        same(&shown).unwrap();
    }
    assert_eq!(play.frame().table.counters.drawn_dynamic, 0);
}

/// A caster that starts again soon after it was cached waits longer the next time.
#[test]
fn a_restless_caster_waits_longer() {
    let mut play = Play::new(7, small());
    let mut waits = Vec::new();
    play.frame();
    for _ in 0..3 {
        play.animate();
        play.frame();
        let frames = (1..100).find(|_| play.frame().kept.tracked.iter().all(|t| t.state != DYNAMIC));
        waits.push(frames.unwrap());
    }
    assert_eq!(waits, [3, 6, 12]);
}

/// A change invalidates the pages that its old and its new bounds touch, and no others.
#[test]
fn invalidation_is_exact() {
    let mut play = Play::new(11, small());
    let before = play.frame();
    let (i, _) = before.kept.tracked.iter().enumerate().filter(|(_, t)| t.state == STATIC).nth(9).unwrap();
    play.instance(i, false, |instance| {
        instance.rows[0][3] += 0.31;
        instance.flags = instance.flags & !3 | CastPolicy::Static as u32;
    });
    let after = play.frame();
    let (_, lights) = umbrage::lab::stages::frame_constants(&play.lab, &play.config).unwrap();
    let bounds = [&before, &after].map(|shown| {
        let t = &shown.kept.tracked[i];
        let across = [lights[0].axis_x, lights[0].axis_y].map(|axis| {
            let [middle, reach] = [t.center, t.reach].map(|v| [0, 1, 2].map(|i| f64::from(v[i])));
            let along = |v: [f64; 3]| (0..3).map(|i| f64::from(axis[i]) * v[i]).sum::<f64>();
            let reach = (0..3).map(|i| f64::from(axis[i]).abs() * reach[i]).sum::<f64>();
            [along(middle) - reach, along(middle) + reach]
        });
        [across[0][0], across[1][0], across[0][1], across[1][1]]
    });
    // the grid: level-0 pages from minus 2^22, as src/engine/constants.rs places them
    let page = f64::from(lights[0].scale[1]);
    let (mut touched, mut others) = (0, 0);
    for slot in before.kept.slots.iter().filter(|s| s.key != [0; 2]) {
        let (level, at) = (key_level(from_words(slot.key)), key_page(from_words(slot.key)));
        let side = page * f64::from(level).exp2();
        let border = side / f64::from(64 - 2);
        let low = at.map(|c| f64::from(c) * side - f64::from(1 << 22) * page);
        let overlap =
            |grow: f64| bounds.iter().any(|b| (0..2).all(|a| b[a] < low[a] + side + grow && b[a + 2] > low[a] - grow));
        let redrawn = after.table.pages.iter().find(|p| p.key == slot.key).map(|p| p.draws & 1 == 1);
        match (overlap(-border), overlap(3.0 * border), redrawn) {
            (true, _, Some(redrawn)) => {
                assert!(redrawn, "{slot:x?} is touched and was not drawn");
                touched += 1;
            }
            (_, false, Some(redrawn)) => {
                assert!(!redrawn, "{slot:x?} is not touched and was drawn");
                others += 1;
            }
            _ => {}
        }
    }
    assert!(touched > 2 && others > 2, "{touched} touched, {others} not");
    same(&after).unwrap();
}

/// However few pages a frame may draw, they are all there in the end.
#[test]
fn what_is_put_off_comes() {
    for pressure in [Pressure::Demand, Pressure::Histogram, Pressure::Level] {
        let config = Config { pages_per_frame: 16, pressure, atlas_bytes: 256 * 4 * 64 * 64, ..small() };
        let mut play = Play::new(23, Config { level_bias: -3.0, ..config });
        let first = play.frame();
        assert!(!first.whole && first.table.counters.drawn > 4, "{pressure:?}: {:?}", first.table.counters);
        let frames = (1..80).find(|_| play.frame().whole);
        assert!(frames.is_some(), "{pressure:?}: {:?}", play.frame().table.counters);
        same(&play.frame()).unwrap();
    }
}

/// A host that dropped a recorded frame says so and starts anew.
#[test]
fn a_forgotten_history_is_none() {
    let mut play = Play::new(29, small());
    play.frame();
    play.cached.forget();
    let again = play.frame();
    assert_eq!(again.table.counters.hits, 0);
    same(&again).unwrap();
}

/// What the checks are worth: a page under a wrong address and a page with old content are both noticed.
#[test]
fn a_stale_page_is_noticed() {
    let mut play = Play::new(13, small());
    let shown = play.frame();
    invariants(&play.config, &shown.table, &shown.kept).unwrap();
    // every page under its neighbour's content: all is consistent but the picture
    let pages = &shown.table.pages;
    let mut slots = shown.kept.slots.clone();
    slots[1..pages.len()].rotate_left(1);
    play.cached.plant(&play.lab, &slots).unwrap();
    let exchanged = play.frame();
    invariants(&play.config, &exchanged.table, &exchanged.kept).unwrap();
    assert!(exchanged.whole && same(&exchanged).is_err(), "exchanged pages were not noticed");
    // a page that two layers claim
    let mut kept = shown.kept;
    let pages = &shown.table.pages;
    kept.slots[pages[0].slot as usize].key = pages[1].key;
    assert!(invariants(&play.config, &shown.table, &kept).is_err(), "a page with two owners was not noticed");
}

/// A light that creeps: coarse pages stay longer than fine ones, and at no tolerance every frame is exact.
#[test]
fn coarse_pages_outlive_a_turning_light() {
    let turn = |play: &mut Play, degrees: f64| {
        let mut view = play.lab.view().clone();
        let Light::Directional { direction, angular_diameter_deg } = view.lights[0].clone() else { unreachable!() };
        let turned = DQuat::from_rotation_z(degrees.to_radians()) * direction;
        view.lights[0] = Light::Directional { direction: turned, angular_diameter_deg };
        play.lab.look(view).unwrap();
    };
    let mut exact = Play::new(17, Config { drift_texels: 0.0, ..small() });
    exact.frame();
    turn(&mut exact, 0.01);
    let shown = exact.frame();
    assert_eq!(shown.table.counters.hits, 0);
    same(&shown).unwrap();

    let mut play = Play::new(17, Config { drift_texels: 0.5, ..small() });
    play.frame();
    let slots_off = |shown: &Shown| {
        let axes = |page: &Page| shown.kept.slots[page.slot as usize].axis_z;
        let newest = shown.kept.slots.iter().max_by_key(|s| s.used).unwrap().axis_z;
        shown.table.pages.iter().filter(|p| p.turned == 1 || axes(p) != newest).count()
    };
    let (mut kept, mut drawn) = ([0u32; 24], [0u32; 24]);
    for _ in 0..60 {
        turn(&mut play, 0.004);
        let shown = play.frame();
        for page in &shown.table.pages {
            let list = if page.draws & 1 == 1 { &mut drawn } else { &mut kept };
            list[key_level(from_words(page.key)) as usize] += 1;
        }
    }
    let share = |level: usize| f64::from(drawn[level]) / f64::from((drawn[level] + kept[level]).max(1));
    let used: Vec<usize> = (0..24).filter(|&l| drawn[l] + kept[l] > 60).collect();
    assert!(used.len() >= 2, "{drawn:?} {kept:?}");
    assert!(used.is_sorted_by(|a, b| share(*a) >= share(*b)), "{drawn:?} {kept:?}");
    assert!(share(used[0]) > 2.0 * share(*used.last().unwrap()), "{drawn:?} {kept:?}");
    // once it rests, everything is exact again
    assert!(slots_off(&play.frame()) > 0);
    let rested = (0..40).map(|_| play.frame()).last().unwrap();
    assert_eq!(slots_off(&rested), 0);
    same(&rested).unwrap();
}

/// Low light over a plane, pages kept while it turns: no false shadow away from edges.
#[test]
fn a_turning_low_light_leaves_no_acne() {
    let (scene, mut view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    for drift_texels in [0.5, 1.0, 4.0] {
        let config = Config { drift_texels, level_bias: 0.0, ..small() };
        let mut kept = EngineStage::new(&lab, &config).unwrap();
        let mut cold = EngineStage::new(&lab, &Config { cache: false, ..config }).unwrap();
        let (mut turned, mut worst) = (0, 0);
        for step in 0..24 {
            let height = (4.0 - 0.004 * f64::from(step)).to_radians();
            view.lights[0] = Light::directional(DVec3::new(0.6, -height.tan() * 0.67, -0.3));
            lab.look(view.clone()).unwrap();
            let ((a, table), (b, _)) = (kept.frame(&lab).unwrap(), cold.frame(&lab).unwrap());
            turned += table.pages.iter().filter(|p| p.turned == 1 && p.draws & 1 == 0).count();
            worst = worst.max(a.iter().zip(&b).filter(|(a, b)| **a < 0.5 && **b >= 0.5).count());
        }
        assert!(turned > 24, "{drift_texels}: only {turned} pages outlived a turn");
        assert!(worst < SIZE[0] as usize, "{drift_texels}: {worst} pixels falsely shadowed");
    }
}

/// Two thousand frames of a wandering camera and moving casters: nothing grows, every budget holds.
#[test]
fn two_thousand_frames_do_not_grow() {
    let config = Config { pages_per_frame: 32, ..small() };
    let (mut scene, base) = scenes::random([64, 36], 19);
    let motion = Motion::synthetic(&mut scene, base.camera.eye, base.camera.target, 2, 19);
    let mut lab = Bench::new(scene, base.clone());
    lab.set_motion(motion);
    let config = Config { size: [64, 36], ..config };
    let mut engine = EngineStage::new(&lab, &config).unwrap();
    let mut most = [0; 2];
    for number in 0..2000u32 {
        let angle = f64::from(number) * 0.02;
        let turn = DQuat::from_rotation_y(0.6 * angle.sin());
        let mut view = base.clone();
        view.camera.eye += DVec3::new(angle.cos(), 0.1 * angle.sin(), (0.7 * angle).sin());
        view.camera.target = view.camera.eye + turn * (base.camera.target - base.camera.eye);
        lab.look(view).unwrap();
        if number % 64 < 40 {
            lab.animate(f64::from(number) / 60.0).unwrap();
        }
        let counters = engine.run(&lab).unwrap();
        assert!(counters.drawn + counters.drawn_dynamic <= 32 && counters.failed == 0, "frame {number}: {counters:?}");
        let half = usize::from(number >= 1000);
        most[half] = most[half].max(counters.leaves + counters.nodes);
    }
    assert!(f64::from(most[1]) < 1.2 * f64::from(most[0]), "the page table fills up: {most:?}");
    let (_, table) = engine.frame(&lab).unwrap();
    invariants(&config, &table, &engine.kept(&lab).unwrap()).unwrap();
}
