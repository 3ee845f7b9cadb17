//! Writes a file under a temporary name in the target's folder, then renames it.

use super::OutputError;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

static COUNTER: AtomicU64 = AtomicU64::new(0);

/// Writes `bytes` to `path`, replacing an existing file in one step. On failure the old file is untouched and nothing
/// new stays in the folder. The folder must exist.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let temporary = temporary_name(path)?;
    let mut written = fs::File::create_new(&temporary).and_then(|mut file| file.write_all(bytes));
    if written.is_ok() {
        written = fs::rename(&temporary, path);
    }
    written.map_err(|error| {
        // the write's own error is the one to report; the file may never have been created
        let _ = fs::remove_file(&temporary);
        OutputError::new(path, error)
    })
}

fn temporary_name(path: &Path) -> Result<PathBuf, OutputError> {
    let Some(name) = path.file_name() else {
        return Err(OutputError::new(path, "not the name of a file"));
    };
    let n = COUNTER.fetch_add(1, Ordering::Relaxed);
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}-{n}.tmp", std::process::id()));
    Ok(path.with_file_name(temporary))
}
