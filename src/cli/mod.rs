//! The command line: what was typed in, one sentence out when it cannot be done.

mod args;
mod bench;
mod compare;
mod failure;
mod figures;
mod folder;
mod info;
mod measure;
mod methods;
mod pictures;
mod print;
mod progress;
mod render;
mod report;
mod results;
mod setup;
mod sweep;
mod view;

use args::{Args, Command};
use clap::Parser;
use failure::Failure;
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

/// Parses the arguments, runs the command and turns a failure into a sentence and an exit code.
pub fn main() -> ExitCode {
    failure::note_panics();
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) if !error.use_stderr() => {
            print::out(&error.render().to_string());
            return ExitCode::SUCCESS;
        }
        Err(error) => return Failure::from(error).report(),
    };
    let done = panic::catch_unwind(AssertUnwindSafe(|| run(&args.command)));
    match done.unwrap_or_else(|_| Err(Failure::panicked())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Render(args) => render::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Bench(args) => bench::run(args),
        Command::View(args) => view::run(args),
        Command::Methods => methods::run(),
        Command::Info => info::run(),
    }
}
