//! A disk that is small enough to be filled.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::PathBuf;
use std::process::Command;

/// A file system in memory, unmounted when the test ends.
pub(crate) struct Disk(PathBuf);

impl Disk {
    /// Mounts one of some megabytes at a new directory; none where that is not allowed.
    pub(crate) fn mounted(path: PathBuf, megabytes: u32) -> Option<Self> {
        fs::create_dir(&path).unwrap();
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={megabytes}m"), "tmpfs"])
            .arg(&path)
            .output();
        mount.is_ok_and(|mount| mount.status.success()).then_some(Self(path))
    }

    /// Fills what is free.
    pub(crate) fn fill(&self) {
        let mut ballast = OpenOptions::new()
            .create(true)
            .append(true)
            .open(self.ballast())
            .unwrap();
        while ballast.write_all(&[0; 4096]).is_ok() {}
    }

    /// Frees what was filled.
    pub(crate) fn free(&self) {
        fs::remove_file(self.ballast()).unwrap();
    }

    fn ballast(&self) -> PathBuf {
        self.0.join("ballast")
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // Nothing uses it any more.
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}
