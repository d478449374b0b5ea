//! Lane code in a library that a Rust toolchain compiled, see `toolchain`.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::cache::{self, Cache, Key};
use crate::{ToolchainError, Words};

/// Last bytes of a library in the cache, before the checksum: a name, and the version of the format.
const MAGIC: &[u8; 8] = b"oneirol\x01";

/// Takes the buffers and their number, the workgroup, and the first lane.
type Entry = unsafe extern "C" fn(*const Words, usize, u32, u32);

/// A library's lane code for one instruction set and number of lanes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    name: String,
    lanes: u32,
}

impl Instance {
    pub(crate) fn new(set: &str, lanes: u32) -> Self {
        let name = format!("{set}x{lanes}");
        Self { name, lanes }
    }

    /// Its name, such as `avx512x64`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of invocations that a call runs.
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    /// Name of its function in the library.
    pub(crate) fn symbol(&self) -> String {
        format!("oneiro_{}", self.name)
    }

    fn line(&self) -> String {
        format!("{} {}\n", self.name, self.lanes)
    }

    fn of_line(line: &str) -> Option<Self> {
        let (name, lanes) = line.split_once(' ')?;
        let lanes = lanes.parse().ok()?;
        Some(Self {
            name: name.to_owned(),
            lanes,
        })
    }
}

/// What a toolchain makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Made {
    /// Bytes of the library.
    pub(crate) library: Vec<u8>,
    /// What is in it, the widest first.
    pub(crate) instances: Vec<Instance>,
    /// Version of the compiler.
    pub(crate) compiler: String,
}

impl Made {
    /// The bytes of its file: the library itself, which systems load whatever follows it; the compiler's version and the
    /// instances, a line each; the length of those lines; the format; and a checksum.
    fn to_bytes(&self, key: &Key) -> Vec<u8> {
        let instances: String = self.instances.iter().map(Instance::line).collect();
        let lines = format!("{}\n{instances}", self.compiler);
        let mut bytes = self.library.clone();
        bytes.extend(lines.as_bytes());
        bytes.extend((lines.len() as u32).to_le_bytes());
        bytes.extend(MAGIC);
        let checksum = blake3::keyed_hash(key.as_bytes(), &bytes);
        bytes.extend(checksum.as_bytes());
        bytes
    }

    /// The compiler's version and the instances, if the bytes are exactly what [`Self::to_bytes`] made with this key.
    fn described(bytes: &[u8], key: &Key) -> Option<(String, Vec<Instance>)> {
        let (bytes, checksum) = bytes.split_last_chunk::<{ blake3::OUT_LEN }>()?;
        if blake3::keyed_hash(key.as_bytes(), bytes) != *checksum {
            return None;
        }
        let (bytes, length) = bytes.strip_suffix(MAGIC)?.split_last_chunk()?;
        let begin = bytes.len().checked_sub(u32::from_le_bytes(*length) as usize)?;
        let mut lines = str::from_utf8(&bytes[begin..]).ok()?.lines();
        let compiler = lines.next()?.to_owned();
        Some((compiler, lines.map(Instance::of_line).collect::<Option<_>>()?))
    }
}

/// The reason why a library can't be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the library {}: {problem}", path.display())]
pub struct LibraryError {
    /// Its file.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: String,
}

/// Lane code of one kernel, ready to run from several threads at a time.
#[derive(Debug)]
pub struct Library {
    /// Owns the memory that `entries` point to.
    _owner: libloading::Library,
    entries: Vec<Entry>,
    instances: Vec<Instance>,
    compiler: String,
    bytes: usize,
}

impl Library {
    /// Loads a library whose file has these bytes.
    pub(crate) fn open(path: &Path, bytes: &[u8], key: &Key) -> Result<Self, String> {
        let (compiler, instances) = Made::described(bytes, key).ok_or("is damaged")?;
        // SAFETY: its bytes are what a compiler made of lane code, which does nothing when it is loaded, and nobody else could
        // write them.
        let library = unsafe { libloading::Library::new(path) };
        let library = library.map_err(|error| format!("can't be loaded: {error}"))?;
        let mut entries = Vec::new();
        for instance in &instances {
            // SAFETY: the library has a function of this type and name for each of its instances. It is only called through
            // `Self`, which owns the library.
            let entry = unsafe { library.get::<Entry>(instance.symbol().as_bytes()) };
            entries.push(*entry.map_err(|error| format!("lacks {}: {error}", instance.name))?);
        }
        Ok(Self {
            _owner: library,
            entries,
            instances,
            compiler,
            bytes: bytes.len(),
        })
    }

    /// Its lane code, the widest first.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The version of Rust that compiled it.
    pub fn compiler(&self) -> &str {
        &self.compiler
    }

    /// Bytes of its file.
    pub fn size(&self) -> usize {
        self.bytes
    }

    /// Runs the lanes of the instance with this index, from `first_lane` on, of one workgroup.
    ///
    /// # Panics
    /// If there is no such instance.
    ///
    /// # Safety
    /// The buffers must be those of the kernel's bindings, in order, each with an element at least. All must be valid for reads
    /// for their whole length, and those that the kernel writes also for writes. While a call runs, no other may access the
    /// words that it writes. The kernel's loops must end.
    pub unsafe fn run(&self, instance: usize, buffers: &[Words], workgroup: u32, first_lane: u32) {
        // SAFETY: the key of the cache has all features of the processor, so that it has those of the code. The caller
        // guarantees the rest.
        unsafe { self.entries[instance](buffers.as_ptr(), buffers.len(), workgroup, first_lane) };
    }
}

/// The file of a library that is not in its cache yet. It is deleted unless it is kept.
#[derive(Debug)]
pub struct Draft {
    pub(crate) new: PathBuf,
    pub(crate) path: PathBuf,
    pub(crate) cache: Cache,
}

impl Draft {
    /// Writes and loads a library.
    pub(crate) fn load(&self, made: &Made, key: &Key) -> Result<Library, ToolchainError> {
        let bytes = made.to_bytes(key);
        cache::write(&self.new, &bytes)?;
        let unloadable = |problem| LibraryError {
            path: self.new.clone(),
            problem,
        };
        Ok(Library::open(&self.new, &bytes, key).map_err(unloadable)?)
    }

    /// Puts it into the cache, instead of an earlier one with its key.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn keep(self) -> Result<(), io::Error> {
        fs::rename(&self.new, &self.path)?;
        self.cache.evict()
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After it was kept there is nothing of this name.
        let _ = fs::remove_file(&self.new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Target;

    /// Bytes with any change, cut off anywhere, or with another key are no library.
    #[test]
    fn damaged_bytes_are_noticed() {
        let target = Target::host().expect("this machine has machine code");
        let made = Made {
            library: (0..100).collect(),
            instances: vec![Instance::new("avx512", 64), Instance::new("avx2", 16)],
            compiler: "1.95.0".into(),
        };
        let key = Key::of_library("text", &target);
        let whole = made.to_bytes(&key);
        assert!(whole.starts_with(&made.library), "it is a library whatever follows it");
        assert_eq!(Made::described(&whole, &key), Some((made.compiler, made.instances)));
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            assert_eq!(Made::described(&changed, &key), None, "byte {at} is changed");
            assert_eq!(Made::described(&whole[..at], &key), None, "it is cut off at {at}");
        }
        assert_eq!(Made::described(&whole, &Key::of_library("other text", &target)), None);
    }
}
