//! `umbrage methods`: what can be chosen.

use super::failure::Failure;
use super::print;
use umbrage::methods::{METHODS, MethodInfo};

/// Prints every method with its source and keys.
pub fn run() -> Result<(), Failure> {
    print::out(&METHODS.iter().map(describe).collect::<Vec<_>>().join("\n"));
    Ok(())
}

fn describe(method: &MethodInfo) -> String {
    let mut text = format!("{}\n  {}\n  source: {}\n", method.name, method.summary, method.source);
    if !method.parameters.is_empty() {
        let cells = |cells: [&str; 4]| std::iter::once("").chain(cells).map(str::to_owned).collect::<Vec<_>>();
        let mut rows = vec![cells(["key", "default", "allowed", "meaning"])];
        rows.extend(method.parameters.iter().map(|p| cells([p.key, p.default, p.allowed, p.meaning])));
        text += &print::table(&rows, rows[0].len());
    }
    text
}
