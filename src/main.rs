//! The program `umbrage`: renders a glTF scene with adaptive shadow maps and measures them against ray tracing.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
