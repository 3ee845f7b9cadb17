//! The picture as a file, with its view.

use crate::lab::View;
use crate::output::{OutputError, Picture, write_file, write_png};
use std::path::Path;

/// Screenshots of one folder.
const MOST: u32 = 9999;

/// Writes the picture and, beside it, the view as a `view.json`; the picture's name. Files that exist are kept.
pub(super) fn save(folder: &Path, picture: &Picture, view: &View) -> Result<String, OutputError> {
    let failed = |what: String| OutputError { path: folder.display().to_string(), what };
    let name = |number: u32, end: &str| format!("umbrage-{number:04}.{end}");
    let free = |number: &u32| ["png", "json"].iter().all(|end| !folder.join(name(*number, end)).exists());
    let number = (1..=MOST).find(free).ok_or_else(|| failed(format!("there are {MOST} screenshots already")))?;
    let json = view.to_json().map_err(|error| failed(error.to_string()))?;
    write_file(&folder.join(name(number, "json")), json.as_bytes())?;
    write_png(&folder.join(name(number, "png")), picture)?;
    Ok(name(number, "png"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::DEFAULT_SIZE;

    #[test]
    fn screenshots_keep_each_other() {
        let folder = std::env::temp_dir().join(format!("umbrage-screenshots-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let view = View::default_for(&crate::scene::builtin(), DEFAULT_SIZE);
        let picture = Picture::filled(2, 2, [1, 2, 3]);
        let names = [0; 2].map(|_| save(&folder, &picture, &view).unwrap());
        assert_eq!(names, ["umbrage-0001.png", "umbrage-0002.png"]);
        let files = std::fs::read_dir(&folder).unwrap().count();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(files, 4);
        assert!(save(&folder, &picture, &view).is_err(), "a folder that is not there");
    }
}
