//! Files of unit tests.

use std::fs;
use std::path::{Path, PathBuf};

/// A temporary directory, removed when the test ends.
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, content).unwrap();
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A leftover in the system's temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Compares a file of the repository with its expected content. If it differs, the expected content is written next to
/// it, with the suffix `.new`, to be read and moved by hand: nothing is overwritten.
pub(crate) fn holds(path: &Path, text: &str) -> Result<(), String> {
    let old = fs::read_to_string(path).unwrap_or_default();
    let new = PathBuf::from(format!("{}.new", path.display()));
    if old == text {
        let _ = fs::remove_file(new);
        return Ok(());
    }
    let different = old
        .lines()
        .zip(text.lines())
        .enumerate()
        .find(|(_, (old, new))| old != new);
    let place = different.map_or("their length".to_owned(), |(index, (old, new))| {
        format!("line {}: {old:?}, now {new:?}", index + 1)
    });
    fs::write(&new, text).unwrap();
    Err(format!("{} differs from {} in {place}", path.display(), new.display()))
}
