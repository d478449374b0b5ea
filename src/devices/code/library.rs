//! Lane code of kernels composed at run time that a Rust toolchain compiled into libraries of the user's cache, see
//! [`crate::ahead`].

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use oneiro_shader_native as native;
use oneiro_shaders::{Kernel, Words};

/// A kernel's library.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) library: native::Library,
    /// Names of its instances.
    names: Vec<&'static str>,
}

impl Loaded {
    pub(crate) fn new(library: native::Library) -> Self {
        // As long as the program knows its kernels.
        let name = |instance: &native::Instance| &*instance.name().to_owned().leak();
        Self {
            names: library.instances().iter().map(name).collect(),
            library,
        }
    }

    /// Names and numbers of lanes of its lane code, the widest first.
    pub(crate) fn all(&self) -> Vec<(&'static str, u32)> {
        let lanes = self.library.instances().iter().map(native::Instance::lanes);
        self.names.iter().copied().zip(lanes).collect()
    }
}

/// One instance of a library.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    loaded: Arc<Loaded>,
    instance: usize,
}

/// The cache's entry for a kernel: its library, if it has one, or why that can't be used.
type Found = Result<Option<Arc<Loaded>>, String>;

static LOADED: Mutex<BTreeMap<&str, Found>> = Mutex::new(BTreeMap::new());

fn loaded() -> MutexGuard<'static, BTreeMap<&'static str, Found>> {
    // A poisoned lock is fine: entries are added complete or not at all.
    LOADED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The library of a kernel composed at run time. The cache is asked once.
pub(crate) fn of(kernel: &'static Kernel) -> Found {
    let find = || match (native::Target::host(), native::Cache::of_user()) {
        (Ok(target), Some(cache)) => {
            let found = cache.library(&native::Key::of_library(kernel.wgsl, &target));
            let found = found.map_err(|error| error.to_string())?;
            Ok(found.map(|library| Arc::new(Loaded::new(library))))
        }
        _ => Ok(None),
    };
    if !kernel.variants.is_empty() {
        return Ok(None);
    }
    loaded().entry(kernel.name).or_insert_with(find).clone()
}

/// Replaces what is known of a kernel.
pub(crate) fn set(kernel: &'static Kernel, library: Option<Arc<Loaded>>) {
    loaded().insert(kernel.name, Ok(library));
}

/// The reason why a kernel's library can't be used.
pub(crate) fn problem(kernel: &'static Kernel) -> Option<String> {
    of(kernel).err()
}

/// Names and numbers of lanes of a kernel's lane code, the widest first.
pub(crate) fn all(kernel: &'static Kernel) -> Vec<(&'static str, u32)> {
    of(kernel).ok().flatten().map_or_else(Vec::new, |loaded| loaded.all())
}

/// A kernel's lane code by name.
pub(crate) fn named(kernel: &'static Kernel, name: &str) -> Option<Code> {
    let loaded = of(kernel).ok().flatten()?;
    let instance = loaded.names.iter().position(|other| *other == name)?;
    Some(Code { loaded, instance })
}

impl Code {
    /// Number of lanes that a call runs.
    pub(crate) fn lanes(&self) -> u32 {
        self.loaded.library.instances()[self.instance].lanes()
    }

    /// Runs its lanes of one workgroup, from `first_lane` on.
    ///
    /// # Safety
    /// As [`super::LaneCode::run`].
    pub(crate) unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32) {
        let buffers = super::native::words(buffers);
        // SAFETY: the caller guarantees it. The loops of a composed kernel end: each has a bound in the kernel's text.
        unsafe { self.loaded.library.run(self.instance, &buffers, workgroup, first_lane) };
    }
}
