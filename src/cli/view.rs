//! `umbrage view`: a window to look through.

use super::args::ViewArgs;
use super::failure::Failure;
use super::folder::Folder;
use super::print;
use super::progress::Progress;
use super::setup::{self, Movement};
use umbrage::window::{self, WindowOptions};

/// Seed of the movers' places.
const SEED: u64 = 1;

/// Loads the scene, opens the window and returns when it is closed.
pub fn run(args: &ViewArgs) -> Result<(), Failure> {
    // a folder made for screenshots goes again when none were taken
    let _folder = Folder::open(&args.out)?;
    let common = &args.common;
    let animate = args.animate || args.movers.is_some_and(|count| count > 0);
    let movement = Movement { animate, movers: args.movers, seed: SEED, copies: 1 };
    let content = setup::load(common, movement, &Progress::new(common.quiet))?;
    let options = WindowOptions {
        lab: setup::options(common),
        methods: args.methods.0.clone(),
        pace: args.present,
        out: args.out.clone(),
        report: if common.quiet { |_| () } else { |sentence| print::out(&format!("{sentence}\n")) },
    };
    setup::silent(&window::run(options, content)?)
}
