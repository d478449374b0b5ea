//! Code in memory that can be run, and never written again.

use std::ffi::c_void;

use memmap2::{Mmap, MmapMut};
use wasmtime_internal_jit_icache_coherence as icache;

use crate::{Code, Error, Target};

/// A buffer as code sees it: 32-bit words.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Words {
    /// First word.
    pub start: *mut u32,
    /// Words.
    pub len: usize,
}

/// Why a call stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// Its loops have turned as often as they might.
    #[error("the kernel's loops turned {0} times, and had not ended")]
    TurnsUsedUp(u64),
    /// It was given other buffers than it binds.
    #[error("the kernel binds {expected} buffers, and was given {found}")]
    Buffers {
        /// Those that it binds.
        expected: usize,
        /// Those that it was given.
        found: usize,
    },
    /// A buffer without a single element, or beyond what an index reaches.
    #[error("buffer {binding} has {words} words; allowed: {least} to {}", u32::MAX)]
    Size {
        /// Its binding number.
        binding: usize,
        /// Its words.
        words: usize,
        /// Words of an element.
        least: u32,
    },
}

/// Called with the buffers, the workgroup, the first lane and how often loops may turn; returns whether all of that was
/// used up.
type Entry = unsafe extern "C" fn(*const Words, u32, u32, u64) -> u32;

/// Code that can be run. It may be called from several threads at a time.
#[derive(Debug)]
pub struct Native {
    /// Owns what `entry` points to.
    _memory: Mmap,
    entry: Entry,
    lanes: u32,
    strides: Vec<u32>,
}

impl Native {
    /// Puts code into memory.
    ///
    /// # Errors
    /// [`Error::Foreign`] if it was compiled for another machine, [`Error::Memory`] if the system gives none.
    pub fn new(code: &Code) -> Result<Self, Error> {
        let machine = Target::host()?.description();
        if code.target != machine {
            let code = code.target.clone();
            return Err(Error::Foreign { code, machine });
        }
        let mut memory = MmapMut::map_anon(code.bytes.len())?;
        memory.copy_from_slice(&code.bytes);
        let memory = memory.make_exec()?;
        // SAFETY: the mapping is that long and stays where it is.
        unsafe { icache::clear_cache(memory.as_ptr().cast::<c_void>(), memory.len()) }?;
        icache::pipeline_flush_mt()?;
        // SAFETY: what begins there is a function with this signature, compiled for this machine; its callers need not
        // trust it with more than `Self::run` says. It is only called through `Self`, which owns the memory.
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(memory.as_ptr()) };
        Ok(Self {
            _memory: memory,
            entry,
            lanes: code.lanes,
            strides: code.strides.clone(),
        })
    }

    /// Invocations that a call runs.
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    /// Runs invocations `first_lane..first_lane + lanes` of one workgroup, whose loops may turn so often in all.
    ///
    /// # Errors
    /// What [`Stopped`] says. A kernel that has used up its turns leaves the buffers as they are by then.
    ///
    /// # Safety
    /// Every buffer must be valid for reads, and those that the kernel writes for writes, for its whole length; what one
    /// call writes, no other may access at the same time.
    pub unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32, turns: u64) -> Result<(), Stopped> {
        if buffers.len() != self.strides.len() {
            return Err(Stopped::Buffers {
                expected: self.strides.len(),
                found: buffers.len(),
            });
        }
        for (binding, (buffer, &least)) in buffers.iter().zip(&self.strides).enumerate() {
            if buffer.len < least as usize || buffer.len > u32::MAX as usize {
                let words = buffer.len;
                return Err(Stopped::Size { binding, words, least });
            }
        }
        // SAFETY: there are as many buffers as the code looks at, each with an element at least; it clamps every
        // element into its buffer. The caller vouches for what they point to.
        match unsafe { (self.entry)(buffers.as_ptr(), workgroup, first_lane, turns) } {
            0 => Ok(()),
            _ => Err(Stopped::TurnsUsedUp(turns)),
        }
    }
}
