//! A failure of the program: one sentence and an exit code.

use std::path::Path;
use std::process::ExitCode;
use std::sync::OnceLock;
use umbrage::lab::LabError;
use umbrage::output::OutputError;
use umbrage::scene::SceneError;
use umbrage::truth::TruthError;
use umbrage::view::ViewError;

/// Exit code when the command itself is wrong.
const USAGE: u8 = 2;
/// Exit code of every other failure.
const OTHER: u8 = 1;

static FIRST_PANIC: OnceLock<String> = OnceLock::new();

/// Why the program stops.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    text: String,
}

impl Failure {
    /// A failure that is not a mistake in the command.
    pub fn other(text: impl Into<String>) -> Self {
        Self { code: OTHER, text: text.into() }
    }

    /// A panic that was caught: what [`note_panics`] kept stands for the sentence that is missing.
    pub fn panicked() -> Self {
        let cause = FIRST_PANIC.get().map_or("unknown cause", String::as_str);
        Self::other(format!("a defect of umbrage stopped it, please report it: {cause}"))
    }

    /// Prints the sentence and gives the exit code.
    pub fn report(&self) -> ExitCode {
        let sentence: Vec<_> = self.text.split_whitespace().collect();
        // with stderr closed there is nobody left to tell
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("error: {}\n", sentence.join(" ")));
        ExitCode::from(self.code)
    }
}

/// Keeps panics from printing, and the first one's message and place for [`Failure::panicked`].
pub fn note_panics() {
    std::panic::set_hook(Box::new(|panic| {
        FIRST_PANIC.get_or_init(|| panic.to_string());
    }));
}

impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        use clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand as NoCommand;
        let text = if error.kind() == NoCommand {
            "no command was given, allowed are render, compare, bench, view, methods, info and --help".to_owned()
        } else {
            // the sentence ends at the first empty line; usage and tips follow
            let text = error.render().to_string();
            let sentence = text.split("\n\n").next().unwrap_or(&text);
            sentence.trim_start_matches("error:").to_owned()
        };
        Self { code: USAGE, text }
    }
}

impl From<LabError> for Failure {
    fn from(error: LabError) -> Self {
        let code = if matches!(error, LabError::Usage(_)) { USAGE } else { OTHER };
        Self { code, text: error.to_string() }
    }
}

impl From<OutputError> for Failure {
    /// Files are written beside their place first, so that only the name means something to the user.
    fn from(error: OutputError) -> Self {
        let name = Path::new(&error.path).file_name().unwrap_or_default().to_string_lossy();
        Self::other(format!("{name} cannot be written: {}", error.what))
    }
}

impl From<TruthError> for Failure {
    fn from(error: TruthError) -> Self {
        Self::other(error.to_string())
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::other(error.to_string())
    }
}

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        Self::other(error.to_string())
    }
}
