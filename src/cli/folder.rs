//! The output folder: all files of a run appear in it together, or none.

use super::failure::Failure;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// An output folder that was found to be writable.
pub struct Folder {
    path: PathBuf,
    /// Folders made for this run, deepest first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Makes the folder where it is missing and tries that it can be written, before any work is done.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let missing = path.ancestors().filter(|a| !a.as_os_str().is_empty() && !a.exists());
        let folder = Self { path: path.to_owned(), made: missing.map(Path::to_owned).collect() };
        let tried = fs::create_dir_all(path).and_then(|()| folder.stage()).and_then(fs::remove_dir);
        tried.map_err(|error| folder.refuse(&error))?;
        Ok(folder)
    }

    /// Lets `write` fill an empty folder beside the results, then moves its files into place.
    pub fn fill(mut self, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        let stage = Stage(self.stage().map_err(|error| self.refuse(&error))?);
        write(&stage.0)?;
        self.take(&stage.0).map_err(|error| self.refuse(&error))?;
        self.made.clear();
        Ok(())
    }

    fn stage(&self) -> io::Result<PathBuf> {
        let stage = self.path.join(format!(".umbrage-{}", std::process::id()));
        fs::create_dir(&stage).map(|()| stage)
    }

    fn take(&self, stage: &Path) -> io::Result<()> {
        let files: Vec<_> = fs::read_dir(stage)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<_>>()?;
        // a folder in the place of a file would stop the moving half way
        if let Some(name) = files.iter().find(|name| self.path.join(name).is_dir()) {
            return Err(io::Error::other(format!("{} in it is a folder", name.to_string_lossy())));
        }
        files.iter().try_for_each(|name| fs::rename(stage.join(name), self.path.join(name)))
    }

    fn refuse(&self, error: &io::Error) -> Failure {
        let path = self.path.display();
        Failure::other(format!(
            "--out '{path}' cannot be written ({error}), allowed is a folder that can be made or written"
        ))
    }
}

impl Drop for Folder {
    /// Removes the folders that were made for a run that failed; a folder with anything in it stays.
    fn drop(&mut self) {
        for path in &self.made {
            let _ = fs::remove_dir(path);
        }
    }
}

/// A folder of this process that goes away with what is left in it.
struct Stage(PathBuf);

impl Drop for Stage {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
