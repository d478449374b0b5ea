//! A directory of compiled code. Each file is named by a hash of everything that the code depends on.
//!
//! Code in it is executed, so on Unix a directory or file is ignored if it isn't the user's, or if others can write to it.

use std::ffi::OsStr;
use std::fs::{self, File, Metadata};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, process};

use crate::{Code, Target, narrow};

/// Hash of everything that code depends on: the kernel's text, the number of lanes, the machine, and the compilers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(blake3::Hash);

/// Hash of the compilers' sources, and of the versions of all libraries.
const BUILD: &str = env!("ONEIRO_SHADER_NATIVE");

impl Key {
    /// Makes the key for a kernel's joined WGSL.
    pub fn new(wgsl: &str, lanes: u32, target: &Target) -> Self {
        Self::of(BUILD, &target.description(), lanes, wgsl)
    }

    fn of(build: &str, target: &str, lanes: u32, wgsl: &str) -> Self {
        let mut hasher = blake3::Hasher::new();
        for part in [build, narrow::VERSION, target, &lanes.to_string(), wgsl] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
        Self(hasher.finalize())
    }

    pub(crate) fn as_bytes(&self) -> &[u8; blake3::OUT_LEN] {
        self.0.as_bytes()
    }
}

/// A directory of compiled code.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
    capacity: u64,
}

/// Bytes that a cache holds unless [`Cache::with_capacity`] says otherwise: hundreds of kernels.
const CAPACITY: u64 = 64 << 20;

impl Cache {
    /// A cache in a directory, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            capacity: CAPACITY,
        }
    }

    /// Sets the number of bytes beyond which saving deletes the oldest entries. The default is 64 MiB.
    #[must_use]
    pub fn with_capacity(mut self, bytes: u64) -> Self {
        self.capacity = bytes;
        self
    }

    /// The user's cache: below `$XDG_CACHE_HOME`, or where the system keeps caches. `None` if the environment names no home
    /// directory.
    pub fn of_user() -> Option<Self> {
        let named = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let caches = named("XDG_CACHE_HOME").or_else(|| {
            if cfg!(windows) {
                named("LOCALAPPDATA")
            } else if cfg!(target_os = "macos") {
                named("HOME").map(|home| home.join("Library/Caches"))
            } else {
                named("HOME").map(|home| home.join(".cache"))
            }
        });
        caches.map(|caches| Self::new(caches.join("oneiro/kernels")))
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(key.0.to_hex().as_str())
    }

    /// Reads the code of a key. `None` if there is none, if it is damaged, or if another user could have written it.
    pub fn load(&self, key: &Key) -> Option<Code> {
        Code::from_bytes(&self.read(&self.path(key))?, key)
    }

    /// Reads a file of the directory. `None` if there is none, or if another user could have written it.
    fn read(&self, path: &Path) -> Option<Vec<u8>> {
        let folder = fs::metadata(&self.folder).ok()?;
        let mut file = File::open(path).ok()?;
        if !is_private(&folder) || !is_private(&file.metadata().ok()?) {
            return None;
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }

    /// Saves code, replacing what is there for the key. Deletes the oldest entries if there are too many bytes.
    ///
    /// # Errors
    /// Errors of the file system, and a directory that another user can write to. Callers can ignore them: the code is then
    /// compiled again next time.
    pub fn save(&self, key: &Key, code: &Code) -> Result<(), io::Error> {
        self.create()?;
        let path = self.path(key);
        let new = unfinished(&path);
        let saved = write(&new, &code.to_bytes(key)).and_then(|()| fs::rename(&new, path));
        if saved.is_err() {
            let _ = fs::remove_file(&new);
        }
        saved.and_then(|()| self.evict())
    }

    /// Creates the directory, which only its user can read and write, unless it is there.
    ///
    /// # Errors
    /// Errors of the file system, and a directory that another user can write to.
    fn create(&self) -> Result<(), io::Error> {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true);
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(&self.folder)?;
        if !is_private(&fs::metadata(&self.folder)?) {
            let problem = format!(
                "{} belongs to another user, or others can write to it",
                self.folder.display()
            );
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, problem));
        }
        Ok(())
    }

    /// Returns the code of a key. If there is none, compiles it and saves it if possible.
    ///
    /// # Errors
    /// Errors of the compiler.
    pub fn load_or<E>(&self, key: &Key, compile: impl FnOnce() -> Result<Code, E>) -> Result<Code, E> {
        if let Some(code) = self.load(key) {
            return Ok(code);
        }
        let code = compile()?;
        let _ = self.save(key, &code);
        Ok(code)
    }

    /// Deletes the oldest entries until the others fit.
    fn evict(&self) -> Result<(), io::Error> {
        let mut entries = Vec::new();
        for entry in fs::read_dir(&self.folder)? {
            let entry = entry?;
            // Another program may have deleted it by now.
            if is_entry(&entry.file_name())
                && let Ok(metadata) = entry.metadata()
            {
                entries.push((metadata.modified()?, metadata.len(), entry.path()));
            }
        }
        entries.sort();
        let mut bytes: u64 = entries.iter().map(|(_, bytes, _)| bytes).sum();
        for (_, length, path) in entries {
            if bytes <= self.capacity {
                break;
            }
            let _ = fs::remove_file(path);
            bytes -= length;
        }
        Ok(())
    }
}

/// Returns whether a file's name begins with a key, as those of entries and of unfinished ones do.
fn is_entry(name: &OsStr) -> bool {
    let digits = name.as_encoded_bytes().get(..2 * blake3::OUT_LEN);
    digits.is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit))
}

/// The name that a file has until it is complete, which no other program or thread uses.
fn unfinished(path: &Path) -> PathBuf {
    static MADE: AtomicU32 = AtomicU32::new(0);
    let number = MADE.fetch_add(1, Ordering::Relaxed);
    path.with_extension(format!("{}.{number}", process::id()))
}

/// Writes a new file that only its user can read and write.
fn write(path: &Path, bytes: &[u8]) -> Result<(), io::Error> {
    let mut options = File::options();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)?.write_all(bytes)
}

/// Returns whether a file or directory is the user's, and nobody else can write to it.
#[cfg(unix)]
fn is_private(metadata: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    // SAFETY: the function has no conditions, and can't fail.
    let user = unsafe { libc::geteuid() };
    metadata.uid() == user && metadata.mode() & 0o022 == 0
}

/// Elsewhere, caches are below the user's own directory, which the system protects.
#[cfg(not(unix))]
fn is_private(_: &Metadata) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change of any part changes the key, even if text only moves from one part to the next.
    #[test]
    fn a_key_depends_on_all_parts() {
        let target = Target::host().expect("this machine has machine code");
        let description = target.description();
        let key = Key::of(BUILD, &description, 4, "text");
        assert_eq!(key, Key::new("text", 4, &target));
        for other in [
            Key::of(&format!("{BUILD}0"), &description, 4, "text"),
            Key::of(BUILD, &format!("{description} has_more"), 4, "text"),
            Key::of(BUILD, &description, 8, "text"),
            Key::of(BUILD, &description, 4, "other text"),
            Key::of(BUILD, &description[1..], 4, "text"),
            Key::of(&format!("{BUILD}{}", &description[..1]), &description[1..], 4, "text"),
        ] {
            assert_ne!(key, other);
        }
        let moved = [(44, "text"), (4, "4text")].map(|(lanes, text)| Key::of(BUILD, &description, lanes, text));
        assert_ne!(moved[0], moved[1]);
    }
}
