//! What can be typed after `umbrage`.

use clap::{ArgAction, Parser, Subcommand};
use std::path::PathBuf;
use umbrage::methods::{self, MethodSpec};
use umbrage::view::MAX_SIDE;

const EXAMPLES: &str = "\
Examples:
  umbrage render --out out
  umbrage compare town.glb --methods rmsm,uniform:resolution=4096,raytraced --out out
  umbrage methods
  umbrage info";
const RENDER_EXAMPLE: &str = "\
Example:
  umbrage render town.glb --size 1920x1080 --method rmsm:atlas_mib=128 --truth --out out";
const COMPARE_EXAMPLE: &str = "\
Example:
  umbrage compare town.glb --methods rmsm,uniform:resolution=4096,fit=samples,raytraced --out out";
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
    /// Lists the methods with their sources and keys.
    #[command(after_help = METHODS_EXAMPLE)]
    Methods,
    /// Lists the Vulkan devices and says for each what it lacks.
    #[command(after_help = INFO_EXAMPLE)]
    Info,
}

/// What is looked at, where it is drawn and where the results go.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// A .gltf or .glb file, or `builtin`.
    #[arg(value_name = "SCENE", default_value = "builtin")]
    pub scene: PathBuf,
    /// A view.json; without it camera and sun are chosen from the scene.
    #[arg(long, value_name = "FILE")]
    pub view: Option<PathBuf>,
    /// Size of the image in pixels; without it the view's, else 1280x720.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Number of the device as `umbrage info` lists it; without it the best usable one.
    #[arg(long, value_name = "N")]
    pub device: Option<usize>,
    /// Whether BLEND materials cast shadows.
    #[arg(long, value_name = "true|false", default_value_t = true, action = ArgAction::Set)]
    pub blend_casts: bool,
    /// Turns on the Vulkan validation layer; any message of it is an error.
    #[arg(long)]
    pub validation: bool,
    /// Prints nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Folder for the results; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub common: Common,
    /// The method, NAME[:key=value,...]; `umbrage methods` lists them.
    #[arg(long, value_name = "SPEC", default_value = "rmsm", value_parser = method)]
    pub method: MethodSpec,
    /// Measures the result against ray tracing.
    #[arg(long)]
    pub truth: bool,
    /// Writes pictures of the method's inner state.
    #[arg(long)]
    pub debug: bool,
    /// Timed frames, 1 to 1000, after 3 that are not timed.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub frames: u32,
}

#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    #[command(flatten)]
    pub common: Common,
    /// The methods, A,B:key=value,...; the first is the measure of the others.
    #[arg(long, value_name = "LIST", value_parser = method_list)]
    pub methods: MethodList,
    /// Timed rounds, 1 to 1000, after 3 that are not timed; each runs every method once.
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,
}

/// The methods in the order typed.
#[derive(Debug, Clone)]
pub struct MethodList(pub Vec<MethodSpec>);

fn size(text: &str) -> Result<[u32; 2], String> {
    let allowed = format!("allowed is WxH with 1 to {MAX_SIDE} pixels a side, such as 1280x720");
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|side| (1..=MAX_SIDE).contains(side))).ok_or(allowed)
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
    fn the_arguments_are_consistent() {
        <Args as clap::CommandFactory>::command().debug_assert();
    }
}
