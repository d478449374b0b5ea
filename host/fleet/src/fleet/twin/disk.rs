//! A disk that is small enough to be filled.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;

/// A file system in memory at a directory.
pub(super) struct SmallDisk {
    directory: PathBuf,
}

impl SmallDisk {
    /// Its size, MB: many times what a daemon writes between two of its checkpoints.
    const SIZE: u32 = 64;
    /// The file that fills it.
    const BALLAST: &str = ".full";

    /// Mounts one at a directory, which is made.
    ///
    /// # Errors
    /// Exit 4: that is not allowed; exit 6: the directory can't be made.
    pub(super) fn mount(directory: &Path) -> Result<Self> {
        plain::make_directory(directory).map_err(|error| Failure::storage(directory, &error))?;
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={}m", Self::SIZE), "tmpfs"])
            .arg(directory)
            .output();
        let directory = directory.to_owned();
        if mount.is_ok_and(|mount| mount.status.success()) {
            return Ok(Self { directory });
        }
        Err(Failure::device(format_args!(
            "{}: the script has a full disk, which needs the right to mount one; run the command as root, or in a namespace: \
             unshare --user --map-root-user --mount",
            directory.display()
        )))
    }

    fn ballast(&self) -> PathBuf {
        self.directory.join(Self::BALLAST)
    }

    /// Fills what is free.
    pub(super) fn fill(&self) {
        let ballast = plain::append_or_create(&self.ballast());
        if let Ok(mut ballast) = ballast {
            while ballast.write_all(&[0; 4096]).is_ok() {}
            // Smaller than a block.
            while ballast.write_all(&[0]).is_ok() {}
        }
    }

    /// Frees what was filled.
    pub(super) fn free(&self) {
        // It may not be filled.
        let _ = fs::remove_file(self.ballast());
    }

    /// Unmounts it, and keeps its files at the same place.
    ///
    /// # Errors
    /// Exit 6.
    pub(super) fn keep(self) -> Result {
        self.free();
        let mut copy = self.directory.clone().into_os_string();
        copy.push(".kept");
        let copy = PathBuf::from(copy);
        let failed = |error| Failure::storage(&self.directory, &error);
        copied(&self.directory, &copy).map_err(failed)?;
        self.unmount();
        fs::remove_dir(&self.directory)
            .and_then(|()| fs::rename(&copy, &self.directory))
            .map_err(failed)
    }

    fn unmount(&self) {
        // Processes that still use it can go on.
        let _ = Command::new("umount").arg("--lazy").arg(&self.directory).output();
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        self.unmount();
    }
}

fn copied(from: &Path, to: &Path) -> std::io::Result<()> {
    plain::make_new_directory(to)?;
    for entry in fs::read_dir(from)? {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name()))?;
        if path.is_dir() {
            copied(&path, &to.join(name))?;
        } else if path.is_file() {
            std::io::copy(&mut plain::open(&path)?, &mut plain::create(&to.join(name))?)?;
        }
    }
    Ok(())
}
