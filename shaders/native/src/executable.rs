//! Executable memory, which is never written to again.

use std::ffi::c_void;
use std::io;

use memmap2::{Mmap, MmapMut};
use wasmtime_internal_jit_icache_coherence as icache;

use crate::{Error, Words};

/// Takes the buffers, the workgroup, the first lane, and the turns that loops may take. Returns 1 if those were used up, else
/// 0. On 64-bit x86 it is called in the same way on all systems.
#[cfg(target_arch = "x86_64")]
type Entry = unsafe extern "sysv64" fn(*const Words, u32, u32, u64) -> u32;
#[cfg(not(target_arch = "x86_64"))]
type Entry = unsafe extern "C" fn(*const Words, u32, u32, u64) -> u32;

/// A function in executable memory.
#[derive(Debug)]
pub(crate) struct Executable {
    /// Owns the memory that `entry` points to.
    _memory: Mmap,
    entry: Entry,
}

impl Executable {
    /// Copies a function that was compiled for this machine.
    ///
    /// # Errors
    /// [`Error::Memory`] if the system provides none.
    pub(crate) fn new(code: &[u8]) -> Result<Self, Error> {
        let mut memory = MmapMut::map_anon(code.len())?;
        memory.copy_from_slice(code);
        let memory = memory.make_exec()?;
        // SAFETY: the range is that of the mapping, which stays where it is.
        let cleared = unsafe { icache::clear_cache(memory.as_ptr().cast::<c_void>(), memory.len()) };
        // Their error has another type on each system.
        cleared.map_err(|error| io::Error::other(error.to_string()))?;
        icache::pipeline_flush_mt().map_err(|error| io::Error::other(error.to_string()))?;
        // SAFETY: a function with this signature starts there, compiled for this machine. It is only called through `Self`,
        // which owns the memory.
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(memory.as_ptr()) };
        Ok(Self { _memory: memory, entry })
    }

    /// Runs the function.
    ///
    /// # Safety
    /// As [`crate::Native::run`]; all buffers are there, and none is shorter than an element.
    pub(crate) unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32, turns: u64) -> u32 {
        // SAFETY: the code clamps every index into its buffer. The caller guarantees that they are valid.
        unsafe { (self.entry)(buffers.as_ptr(), workgroup, first_lane, turns) }
    }
}
