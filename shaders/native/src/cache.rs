//! A directory of compiled code. Each file is named by a hash of everything that the code depends on.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, io, process};

use crate::{Code, Target};

/// Hash of everything that code depends on: the kernel's text, the number of lanes, the machine, and the compilers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(blake3::Hash);

impl Key {
    /// Makes the key for a kernel's joined WGSL.
    pub fn new(wgsl: &str, lanes: u32, target: &Target) -> Self {
        let mut hasher = blake3::Hasher::new();
        let target = target.description();
        for part in [
            env!("ONEIRO_SHADER_NATIVE"),
            cranelift_codegen::VERSION,
            &target,
            &lanes.to_string(),
            wgsl,
        ] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
        Self(hasher.finalize())
    }

    pub(crate) fn as_bytes(&self) -> &[u8; blake3::OUT_LEN] {
        self.0.as_bytes()
    }
}

/// A directory of compiled code. It must belong to one user, since whoever can write to it decides what runs.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// A cache in a directory, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
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

    /// Reads the code of a key. `None` if there is none, or if it is damaged.
    pub fn load(&self, key: &Key) -> Option<Code> {
        Code::from_bytes(&fs::read(self.path(key)).ok()?, key)
    }

    /// Saves code, replacing what is there for the key.
    ///
    /// # Errors
    /// Errors of the file system. Callers can ignore them: the code is then compiled again next time.
    pub fn save(&self, key: &Key, code: &Code) -> Result<(), io::Error> {
        static SAVED: AtomicU32 = AtomicU32::new(0);
        create(&self.folder)?;
        // Until it is complete, it has a name that no other program or thread uses.
        let own = format!("{}.{}.new", process::id(), SAVED.fetch_add(1, Ordering::Relaxed));
        let new = self.folder.join(own);
        let saved = fs::write(&new, code.to_bytes(key)).and_then(|()| fs::rename(&new, self.path(key)));
        if saved.is_err() {
            let _ = fs::remove_file(&new);
        }
        saved
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
}

/// Creates a directory that only its user can read and write.
fn create(folder: &Path) -> Result<(), io::Error> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}
