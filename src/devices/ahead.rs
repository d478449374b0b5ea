//! Kernels composed at run time, compiled ahead of time by a Rust toolchain at the full width of this machine. Their lane code is
//! that of the kernels that ship, and has the same bits. It is kept in the user's cache, where [`Cpu`](crate::cpu::Cpu) finds it by
//! itself.

use std::sync::Arc;

use oneiro_shader_native as native;
pub use oneiro_shader_native::{Toolchain, ToolchainError};

use crate::batch::Worlds;
use crate::devices::code::{library, trees_of};
use crate::devices::variants;

/// A kernel's lane code in the cache.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compiled {
    /// Names of the lane codes, such as `avx512x64`, the widest first.
    pub lane_codes: Vec<&'static str>,
    /// Version of Rust that compiled them.
    pub rust: String,
    /// Bytes of their file.
    pub bytes: usize,
}

impl Compiled {
    fn of(loaded: &library::Loaded) -> Self {
        Self {
            lane_codes: loaded.all().into_iter().map(|(name, _)| name).collect(),
            rust: loaded.library.compiler().to_owned(),
            bytes: loaded.library.size(),
        }
    }
}

/// Reasons why a kernel isn't compiled.
#[derive(Debug, thiserror::Error)]
pub enum Error<E> {
    /// Its lane code is part of this program.
    #[error("the kernel {0} ships with this program, compiled")]
    Ships(&'static str),
    /// There is no place to keep it.
    #[error(
        "there is no cache for compiled kernels: the environment names no home directory; allowed: an absolute path in the \
         variable XDG_CACHE_HOME"
    )]
    NoCache,
    /// This processor runs no code that isn't part of the program.
    #[error("{0}")]
    Machine(String),
    /// The toolchain's.
    #[error(transparent)]
    Toolchain(#[from] ToolchainError),
    /// What checked it said.
    #[error(transparent)]
    Check(E),
}

/// Whether the lane code of the kernel of these worlds is part of this program.
pub fn ships(worlds: &Worlds) -> bool {
    variants::ships(worlds.kernel())
}

/// The cache's entry for the kernel of these worlds.
pub fn compiled(worlds: &Worlds) -> Option<Compiled> {
    let loaded = library::of(worlds.kernel()).ok().flatten()?;
    Some(Compiled::of(&loaded))
}

/// Compiles the lane code of the kernel of these worlds. While `check` runs, every [`Cpu`](crate::cpu::Cpu) of this program has it;
/// if the check succeeds, it is put into the cache, where all later programs find it.
///
/// # Errors
/// See [`Error`]. Nothing in the cache is changed then.
pub fn compile<E>(
    worlds: &Worlds,
    toolchain: &Toolchain,
    check: impl FnOnce(&Compiled) -> Result<(), E>,
) -> Result<Compiled, Error<E>> {
    let kernel = worlds.kernel();
    if ships(worlds) {
        return Err(Error::Ships(kernel.name));
    }
    let machine = |problem: String| Error::Machine(problem);
    let target = native::Target::host().map_err(|error| machine(error.to_string()))?;
    let cache = native::Cache::of_user().ok_or(Error::NoCache)?;
    let trees = trees_of(kernel).map_err(|error| machine(error.to_string()))?;
    let before = library::of(kernel).ok().flatten();
    let key = native::Key::of_library(kernel.wgsl, &target);
    let (library, draft) = cache.compile(&key, toolchain, &trees)?;
    let loaded = Arc::new(library::Loaded::new(library));
    let compiled = Compiled::of(&loaded);
    library::set(kernel, Some(loaded));
    let kept = check(&compiled)
        .map_err(Error::Check)
        .and_then(|()| draft.keep().map_err(|error| Error::Toolchain(error.into())));
    if let Err(error) = kept {
        library::set(kernel, before);
        return Err(error);
    }
    Ok(compiled)
}
