//! Compiles kernels to machine code at run time, with no compiler installed: the tree that the shader compiler makes of
//! WGSL becomes instructions by `emit`, through Cranelift.
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
mod memory;

use cranelift_codegen::isa::OwnedTargetIsa;
use oneiro_shader_compiler::Trees;

pub use cache::{Cache, Key};
pub use code::Code;
pub use memory::{Native, Stopped, Words};

/// Numbers of lanes that code is compiled for.
pub const LANES: [u32; 3] = [4, 8, 16];

/// The most memory that a call may take of its thread's stack, in bytes.
const FRAME: u64 = 1 << 18;

/// Why there is no code.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No code can be compiled for this machine.
    #[error("this machine can't run code compiled at run time: {0}")]
    Machine(String),
    /// A number of lanes that is not one of [`LANES`].
    #[error("{0} lanes; allowed: 4, 8, 16")]
    Lanes(u32),
    /// The program needs more than the code generator or a thread's stack has.
    #[error("the kernel is too large to be compiled, or its local variables take more than {FRAME} bytes")]
    TooLarge,
    /// The code generator failed, or made what can't stand by itself.
    #[error("the kernel can't be compiled: {0}")]
    Backend(String),
    /// Code that was compiled for another machine.
    #[error("the code is for {code}; this is {machine}")]
    Foreign {
        /// Its machine.
        code: String,
        /// This one.
        machine: String,
    },
    /// The system gave no memory for code.
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
    /// [`Error::Machine`] if its processor isn't one of 64 bits by x86, with SSE4.1, or by ARM.
    pub fn host() -> Result<Self, Error> {
        cranelift::host(false).map(|isa| Self { isa })
    }

    /// This machine, with all tests that the code generator has of its own work. Compiling takes several times as long.
    ///
    /// # Errors
    /// As [`Self::host`].
    pub fn checked_host() -> Result<Self, Error> {
        cranelift::host(true).map(|isa| Self { isa })
    }

    /// What code must be compiled for to run here: the machine, and what its processor has.
    pub fn description(&self) -> String {
        cranelift::description(&*self.isa)
    }

    /// Compiles a program for so many lanes.
    ///
    /// # Errors
    /// [`Error::Lanes`], [`Error::TooLarge`] or [`Error::Backend`].
    pub fn compile(&self, trees: &Trees, lanes: u32) -> Result<Code, Error> {
        if !LANES.contains(&lanes) {
            return Err(Error::Lanes(lanes));
        }
        let words: u64 = trees.tidied.arrays.iter().map(|array| array.init.len() as u64).sum();
        if words * u64::from(4 * lanes) > FRAME {
            return Err(Error::TooLarge);
        }
        Ok(Code {
            lanes,
            target: self.description(),
            strides: trees.strides.clone(),
            bytes: cranelift::compile(&*self.isa, trees, lanes)?,
        })
    }
}
