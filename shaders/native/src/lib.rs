//! Compiles kernels to machine code at run time, without a compiler on the machine: `emit` turns the shader compiler's tree
//! into instructions, through Cranelift. Where there is a Rust toolchain, it can also compile them ahead of time
//! (`toolchain`, with the feature `ahead`).
//!
//! ```
//! use oneiro_shader_compiler::{Part, trees};
//! use oneiro_shader_native::{Native, Target, Words};
//!
//! let text = "@group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
//!     @compute @workgroup_size(64)
//!     fn main(@builtin(local_invocation_index) lane: u32) { numbers[lane] += lane; }";
//! let part = Part { path: "sums.wgsl".into(), text: text.into() };
//! let code = Target::host()?.compile(&trees(&[part]).expect("it is exact"), 16)?;
//! let kernel = Native::new(&code)?;
//! let mut numbers = [100; 64];
//! let buffers = [Words { start: numbers.as_mut_ptr(), len: numbers.len() }];
//! for first_lane in (0..64).step_by(16) {
//!     // SAFETY: the buffer is valid for all of its length, and no other call uses it.
//!     unsafe { kernel.run(&buffers, 0, first_lane, 1_000) }.expect("it has no loops");
//! }
//! assert_eq!(numbers[..3], [100, 101, 102]);
//! # Ok::<(), oneiro_shader_native::Error>(())
//! ```

mod assembler;
mod cache;
mod code;
mod cranelift;
mod emit;
#[cfg(feature = "ahead")]
mod library;
mod run;
mod share;
mod stack;
#[cfg(feature = "ahead")]
mod toolchain;

use cranelift_codegen::isa::OwnedTargetIsa;
use oneiro_shader_compiler::Trees;

pub use cache::{Cache, Key};
pub use code::Code;
#[cfg(feature = "ahead")]
pub use library::{Draft, Instance, Library, LibraryError};
pub use run::{Native, Stopped, Words};
pub use stack::most_lanes;
#[cfg(feature = "ahead")]
pub use toolchain::{Toolchain, ToolchainError};

use stack::{ARRAYS, FRAME, check_arrays};

/// Numbers of lanes that code can be compiled for.
pub const LANES: [u32; 3] = [4, 8, 16];

/// Reasons why there is no code.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Code can't be compiled for this machine.
    #[error("this machine can't run code compiled at run time: {0}")]
    Machine(String),
    /// A number of lanes that isn't in [`LANES`].
    #[error("{0} lanes; allowed: 4, 8, 16")]
    Lanes(u32),
    /// The local arrays of all lanes don't fit on a thread's stack.
    #[error("the kernel's local arrays take {0} bytes; allowed: at most {ARRAYS}")]
    Arrays(u64),
    /// The kernel is too large for the code generator, or its variables for a thread's stack.
    #[error("the kernel is too large to be compiled, or its local variables take more than {FRAME} bytes")]
    TooLarge,
    /// The code generator failed, or produced code that refers to something outside of itself.
    #[error("the kernel can't be compiled: {0}")]
    Backend(String),
    /// The code was compiled for another machine.
    #[error("the code is for {code}; this is {machine}")]
    Foreign {
        /// The machine that it was compiled for.
        code: String,
        /// This machine.
        machine: String,
    },
    /// The system provided no memory for code.
    #[error("no memory for code: {0}")]
    Memory(#[from] std::io::Error),
}

/// A machine to compile for.
pub struct Target {
    isa: OwnedTargetIsa,
}

impl std::fmt::Debug for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Target").field(&self.description()).finish()
    }
}

impl Target {
    /// This machine.
    ///
    /// # Errors
    /// [`Error::Machine`] unless the processor is 64-bit x86 with SSE4.1, or 64-bit ARM.
    pub fn host() -> Result<Self, Error> {
        cranelift::host(false).map(|isa| Self { isa })
    }

    /// This machine, with all of the code generator's internal checks switched on. Compiling takes several times as long.
    ///
    /// # Errors
    /// As [`Self::host`].
    pub fn checked_host() -> Result<Self, Error> {
        cranelift::host(true).map(|isa| Self { isa })
    }

    /// The machine and its processor's features, as code must name them in order to run here.
    pub fn description(&self) -> String {
        cranelift::description(&*self.isa)
    }

    /// Compiles a program for the given number of lanes.
    ///
    /// # Errors
    /// [`Error::Lanes`], [`Error::Arrays`], [`Error::TooLarge`] or [`Error::Backend`].
    pub fn compile(&self, trees: &Trees, lanes: u32) -> Result<Code, Error> {
        if !LANES.contains(&lanes) {
            return Err(Error::Lanes(lanes));
        }
        check_arrays(trees, lanes)?;
        Ok(Code {
            lanes,
            target: self.description(),
            strides: trees.strides.clone(),
            bytes: cranelift::compile(&*self.isa, trees, lanes)?,
        })
    }
}

/// Words of the longest element of any buffer.
fn longest_element(trees: &Trees) -> u32 {
    trees.strides.iter().max().copied().unwrap_or(1)
}
