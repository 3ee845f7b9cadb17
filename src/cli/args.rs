//! What can be typed after `umbrage`.

use super::sweep::Sweep;
use clap::{Parser, Subcommand, ValueEnum};
use std::path::{Path, PathBuf};
use umbrage::methods::{self, MethodSpec};
use umbrage::scene::{Blend, MAX_COPIES};
use umbrage::view::{CameraPath, MAX_SIDE, MAX_SYNTHETIC_LIGHTS, PATH_NAMES};
use umbrage::window::Pace;

/// Methods that `bench` runs when none are named: a conventional map, the cache, and every page anew in every frame.
const BENCH_METHODS: &str = "uniform:resolution=4096,rmsm,rmsm:cache=off";
/// Methods that `view` switches between when none are named.
const VIEW_METHODS: &str = "rmsm,uniform,csm,raytraced";
/// One turn a frame.
const MAX_SUN_RATE: f64 = 21600.0;

const EXAMPLES: &str = "\
Examples:
  umbrage render --out out
  umbrage compare town.glb --methods rmsm,uniform:resolution=4096,raytraced --out out
  umbrage bench town.glb --path walk --frames 300 --out out
  umbrage view town.glb
  umbrage methods
  umbrage info";
const RENDER_EXAMPLE: &str = "\
Example:
  umbrage render town.glb --size 1920x1080 --method rmsm:atlas_mib=128 --truth --out out";
const COMPARE_EXAMPLE: &str = "\
Examples:
  umbrage compare town.glb --methods rmsm,uniform:resolution=4096,fit=samples,raytraced --out out
  umbrage compare town.glb --methods rmsm,uniform --sweep resolution=512..8192 --out out";
const BENCH_EXAMPLE: &str = "\
Example:
  umbrage bench town.glb --path turn --frames 300 --animate --sun-rate 2 --truth-every 10 --out out";
const VIEW_EXAMPLE: &str = "\
F1 in the window shows the keys.

Example:
  umbrage view town.glb --methods rmsm,rmsm:exact=true,uniform:resolution=8192";
const METHODS_EXAMPLE: &str = "\
Example:
  umbrage methods
  umbrage render --method uniform:resolution=8192 --out out";
const INFO_EXAMPLE: &str = "\
Example:
  umbrage info
  umbrage render --device 1 --out out";

/// Adaptive shadow maps for Vulkan, measured against ray tracing.
#[derive(Debug, Parser)]
#[command(name = "umbrage", version, after_help = EXAMPLES)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Renders one view of a scene: image, shadow mask, surfaces and statistics.
    #[command(after_help = RENDER_EXAMPLE)]
    Render(RenderArgs),
    /// Runs several methods by turns on one view and compares time, memory and error.
    #[command(after_help = COMPARE_EXAMPLE)]
    Compare(CompareArgs),
    /// Runs several methods over the frames of a camera path and reports each frame's time, pages and error.
    #[command(after_help = BENCH_EXAMPLE)]
    Bench(BenchArgs),
    /// Opens a window: fly through a scene, switch methods, see what goes on inside them.
    #[command(after_help = VIEW_EXAMPLE)]
    View(ViewArgs),
    /// Lists the methods with their sources and keys.
    #[command(after_help = METHODS_EXAMPLE)]
    Methods,
    /// Lists the Vulkan devices and says for each what it lacks.
    #[command(after_help = INFO_EXAMPLE)]
    Info,
}

/// What is looked at and where it is drawn.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// A .gltf or .glb file, or `builtin`.
    #[arg(value_name = "SCENE", default_value = "builtin")]
    pub scene: PathBuf,
    /// A view.json; without it camera and sun are chosen from the scene.
    #[arg(long, value_name = "FILE")]
    pub view: Option<PathBuf>,
    /// Lights in place of the view's, spots and points by turns at random places, 1 to 1365.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SYNTHETIC_LIGHTS)))]
    pub lights: Option<u32>,
    /// Size of the image in pixels; without it the view's, else 1280x720.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Number of the device as `umbrage info` lists it; without it the best usable one.
    #[arg(long, value_name = "N")]
    pub device: Option<usize>,
    /// What BLEND materials are as casters: tested (all or nothing, by alpha 0.5), ignored, or translucent (they hold back the
    /// share alpha of the light for methods that can tell and the reference).
    #[arg(long, default_value = "tested")]
    pub blend: BlendArg,
    /// Turns on the Vulkan validation layer; any message of it is an error.
    #[arg(long)]
    pub validation: bool,
    /// Prints nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

/// [`Blend`] as it is typed.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum BlendArg {
    Tested,
    Ignored,
    Translucent,
}

impl From<BlendArg> for Blend {
    fn from(typed: BlendArg) -> Self {
        match typed {
            BlendArg::Tested => Blend::Tested,
            BlendArg::Ignored => Blend::Ignored,
            BlendArg::Translucent => Blend::Translucent,
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub common: Common,
    /// Folder for the results; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The method, NAME[:key=value,...]; `umbrage methods` lists them.
    #[arg(long, value_name = "SPEC", default_value = "rmsm", value_parser = method)]
    pub method: MethodSpec,
    /// Measures the result against ray tracing.
    #[arg(long)]
    pub truth: bool,
    /// Writes pictures of the method's inner state.
    #[arg(long)]
    pub debug: bool,
    /// Timed frames, 1 to 1000, after 3 to 64 that are not timed: until no page is deferred.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub frames: u32,
}

#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub common: Common,
    /// Folder for the results; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The methods, A,B:key=value,...; the first is the measure of the others.
    #[arg(long, value_name = "LIST", value_parser = method_list)]
    pub methods: MethodList,
    /// Timed rounds, 1 to 1000, after 3 to 64 that are not timed; each runs every method once.
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,
    /// Compares also with the share of N ray-traced samples a pixel, a power of two up to 64.
    #[arg(long, value_name = "N", value_parser = coverage)]
    pub coverage: Option<u32>,
    /// Runs those of the methods that have KEY once for every value, the others once, and plots the errors: KEY=A,B,... or
    /// KEY=FIRST..LAST, whole numbers that double.
    #[arg(long, value_name = "KEY=VALUES", value_parser = Sweep::parse)]
    pub sweep: Option<Sweep>,
}

#[derive(Debug, clap::Args)]
pub struct BenchArgs {
    #[command(flatten)]
    pub common: Common,
    /// Folder for the results; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// still, walk, turn, fly, cut (or teleport), zoom, or a .json file {"keys":[{"frame","eye","target","fov_y_deg"}]}.
    #[arg(long, value_name = "NAME|FILE", default_value = "walk", value_parser = path)]
    pub path: PathChoice,
    /// Frames at 60 a second, 1 to 100000, after 3 at the first frame's place that are left out.
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// The methods, A,B:key=value,...; the first is the measure of the others.
    #[arg(long, value_name = "LIST", default_value = BENCH_METHODS, value_parser = method_list)]
    pub methods: MethodList,
    /// Plays the file's first animation; a scene without one gets one mover of 5,000 triangles.
    #[arg(long)]
    pub animate: bool,
    /// Adds movers of 5,000 triangles each, 0 to 64; a file's own animation then stands still.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub movers: Option<u32>,
    /// Copies of the scene side by side, 1 to 64; the view stays that of one.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_COPIES)))]
    pub copies: u32,
    /// Turns the sun about the horizontal axis across it, upwards where above 0; -21600 to 21600 degrees a second.
    #[arg(long, value_name = "DEG_PER_S", default_value_t = 0.0, allow_negative_numbers = true, value_parser = sun_rate)]
    pub sun_rate: f64,
    /// Traces every K-th frame and reports errors there, with K = 1 crawl too; 0 never.
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub truth_every: u32,
    /// Seed of jitter, viewpoints and movers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

#[derive(Debug, clap::Args)]
pub struct ViewArgs {
    #[command(flatten)]
    pub common: Common,
    /// The methods to switch between, A,B:key=value,...; the first is shown first.
    #[arg(long, value_name = "LIST", default_value = VIEW_METHODS, value_parser = method_list)]
    pub methods: MethodList,
    /// Plays the file's first animation; a scene without one gets one mover of 5,000 triangles.
    #[arg(long)]
    pub animate: bool,
    /// Adds movers of 5,000 triangles each, 0 to 64; a file's own animation then stands still.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub movers: Option<u32>,
    /// When a picture reaches the screen: with its refresh (fifo, mailbox) or at once (immediate).
    #[arg(long, value_name = "MODE", default_value = "fifo", value_parser = pace)]
    pub present: Pace,
    /// Folder for screenshots; made where it is missing.
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub out: PathBuf,
}

/// A path as typed; a file is read when the program runs.
#[derive(Debug, Clone)]
pub enum PathChoice {
    Named(CameraPath),
    File(PathBuf),
}

/// The methods in the order typed.
#[derive(Debug, Clone)]
pub struct MethodList(pub Vec<MethodSpec>);

fn coverage(text: &str) -> Result<u32, String> {
    let samples = text.parse().unwrap_or(0u32);
    if samples.is_power_of_two() && samples <= 64 {
        Ok(samples)
    } else {
        Err("allowed is 1, 2, 4, 8, 16, 32 or 64".into())
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let allowed = format!("allowed is WxH with 1 to {MAX_SIDE} pixels a side, such as 1280x720");
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|side| (1..=MAX_SIDE).contains(side))).ok_or(allowed)
}

fn path(text: &str) -> Result<PathChoice, String> {
    let named = CameraPath::named(text).map(PathChoice::Named);
    let file = || Path::new(text).extension().is_some_and(|e| e == "json").then(|| PathChoice::File(text.into()));
    let allowed = || format!("allowed is {} or a file whose name ends in .json", PATH_NAMES.join(", "));
    named.or_else(file).ok_or_else(allowed)
}

fn sun_rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (-MAX_SUN_RATE..=MAX_SUN_RATE).contains(rate));
    rate.ok_or_else(|| format!("allowed is a number of degrees a second from -{MAX_SUN_RATE} to {MAX_SUN_RATE}"))
}

fn pace(text: &str) -> Result<Pace, String> {
    match text {
        "fifo" => Ok(Pace::Fifo),
        "mailbox" => Ok(Pace::Mailbox),
        "immediate" => Ok(Pace::Immediate),
        _ => Err("allowed is fifo, mailbox or immediate".into()),
    }
}

fn checked(spec: MethodSpec) -> Result<MethodSpec, String> {
    methods::check(&spec).map(|()| spec).map_err(|error| error.to_string())
}

fn method(text: &str) -> Result<MethodSpec, String> {
    MethodSpec::parse(text).and_then(checked)
}

fn method_list(text: &str) -> Result<MethodList, String> {
    MethodSpec::parse_list(text)?.into_iter().map(checked).collect::<Result<_, _>>().map(MethodList)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("1280x720"), Ok([1280, 720]));
        assert_eq!(size("16384x1"), Ok([16384, 1]));
        for bad in ["", "x", "0x5", "5x0", "16385x1", "1280", "1280x", "-1x5", "1.5x2", "1280x720x3", "99999999999x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn paths() {
        for name in PATH_NAMES {
            assert!(matches!(path(name), Ok(PathChoice::Named(_))), "{name}");
        }
        assert!(matches!(path("keys/a.json"), Ok(PathChoice::File(file)) if file == Path::new("keys/a.json")));
        for bad in ["", "Walk", "walk ", "keys", "json", ".json", "a.jso", "keys/a"] {
            assert!(path(bad).is_err_and(|error| error.contains("teleport") && error.contains(".json")), "{bad}");
        }
    }

    #[test]
    fn sun_rates() {
        assert_eq!(["0", "-2.5", "21600"].map(sun_rate), [Ok(0.0), Ok(-2.5), Ok(21600.0)]);
        for bad in ["", "nan", "inf", "-inf", "1e999", "21601", "fast", "1 2"] {
            assert!(sun_rate(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn bench_has_defaults_and_bounds() {
        let parse = |text: &str| Args::try_parse_from(format!("umbrage bench --out o {text}").split_whitespace());
        let Ok(Args { command: Command::Bench(args) }) = parse("") else { panic!("bench was not parsed") };
        assert_eq!((args.frames, args.truth_every, args.movers, args.sun_rate), (120, 0, None, 0.0));
        assert_eq!(args.methods.0.len(), 3);
        assert!(parse("--sun-rate -3 --movers 64 --frames 100000 --seed 18446744073709551615").is_ok());
        for bad in [
            "--frames 0",
            "--frames 100001",
            "--copies 0",
            "--copies 65",
            "--movers 65",
            "--movers -1",
            "--truth-every -1",
            "--seed -1",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_arguments_are_consistent() {
        <Args as clap::CommandFactory>::command().debug_assert();
    }
}
