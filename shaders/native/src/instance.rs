//! Functions of other modules of WebAssembly, which the page adds to the table of this one.

use std::sync::{Mutex, PoisonError};

use crate::{Error, FRAME, Words};

/// Takes the buffers, the workgroup, the first lane, the turns that loops may take, and memory for local arrays, [`FRAME`] bytes. Returns 1
/// if the turns were used up, else 0.
type Entry = unsafe extern "C" fn(*const Words, u32, u32, u64, *mut u32) -> u32;

/// Memory for local arrays of the one function that runs at a time.
static MEMORY: Mutex<Vec<u32>> = Mutex::new(Vec::new());

#[link(wasm_import_module = "oneiro")]
unsafe extern "C" {
    /// Makes an instance of a module in the memory of this one, and returns the place of its function `run` in this one's table.
    fn install(code: *const u8, length: usize) -> usize;
    /// Frees a place.
    fn remove(place: usize);
}

/// A function of an instance.
#[derive(Debug)]
pub(crate) struct Executable {
    place: usize,
}

impl Executable {
    /// Makes an instance of a module. A page whose browser refuses it ends this one.
    ///
    /// # Errors
    /// None.
    #[expect(
        clippy::unnecessary_wraps,
        reason = "as machine code, which needs memory of the system"
    )]
    pub(crate) fn new(code: &[u8]) -> Result<Self, Error> {
        // SAFETY: the page reads so many bytes from there.
        let place = unsafe { install(code.as_ptr(), code.len()) };
        Ok(Self { place })
    }

    /// Runs the function.
    ///
    /// # Safety
    /// As [`crate::Native::run`]; all buffers are there, and none is shorter than an element.
    pub(crate) unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32, turns: u64) -> u32 {
        let mut memory = MEMORY.lock().unwrap_or_else(PoisonError::into_inner);
        memory.resize(FRAME as usize / size_of::<u32>(), 0);
        // SAFETY: in WebAssembly, a function's address is its place in the table; there is one with this signature.
        let entry = unsafe { std::mem::transmute::<usize, Entry>(self.place) };
        // SAFETY: the code clamps every index into its buffer, and needs no more memory. The caller guarantees that the buffers are valid.
        unsafe { entry(buffers.as_ptr(), workgroup, first_lane, turns, memory.as_mut_ptr()) }
    }
}

impl Drop for Executable {
    fn drop(&mut self) {
        // SAFETY: nobody calls the function any more.
        unsafe { remove(self.place) }
    }
}
