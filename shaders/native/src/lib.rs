//! Compiles kernels to machine code at run time, without a compiler on the machine: `emit` turns the shader compiler's tree
//! into instructions: by this crate's code generator for AVX2 and AVX-512 (`wide`), or of vectors of 128 bits through Cranelift; in a browser, as a
//! module of WebAssembly.
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
mod control;
#[cfg(not(target_family = "wasm"))]
mod cranelift;
mod emit;
#[cfg_attr(target_family = "wasm", path = "instance.rs")]
mod executable;
mod run;
mod share;
mod stack;
#[cfg(any(target_family = "wasm", test))]
#[cfg_attr(not(target_family = "wasm"), allow(dead_code, reason = "its tests run anywhere"))]
mod web_assembly;
#[cfg_attr(not(target_arch = "x86_64"), path = "no_wide.rs")]
mod wide;

use oneiro_shader_compiler::Trees;

pub use cache::{Cache, Key};
pub use code::Code;
pub use run::{Native, Stopped, Words};

#[cfg(not(target_family = "wasm"))]
use cranelift as narrow;
use stack::{ARRAYS, FRAME, check_arrays, most_at_once};
#[cfg(target_family = "wasm")]
use web_assembly as narrow;

/// Reasons why there is no code.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Code can't be compiled for this machine.
    #[error("this machine can't run code compiled at run time: {0}")]
    Machine(String),
    /// A number of lanes that isn't in [`Target::lanes`].
    #[error("{0} lanes; allowed: {1:?}")]
    Lanes(u32, &'static [u32]),
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

/// A processor to compile for.
pub struct Target {
    code: Generator,
    checked: bool,
}

/// What generates code.
enum Generator {
    /// With vectors of 128 bits, on any machine.
    Narrow(narrow::Machine),
    /// Ours, with vectors of 256 or 512 bits.
    Wide(wide::Vectors),
}

impl std::fmt::Debug for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Target").field(&self.description()).finish()
    }
}

impl Target {
    /// This machine, with vectors of 128 bits.
    ///
    /// # Errors
    /// [`Error::Machine`] unless the processor is 64-bit x86 with SSE4.1, or 64-bit ARM, or this is WebAssembly.
    pub fn host() -> Result<Self, Error> {
        let checked = false;
        narrow::host(checked).map(|machine| Self {
            code: Generator::Narrow(machine),
            checked,
        })
    }

    /// This machine with vectors of 512 bits, 64-bit x86; `None` unless its processor has AVX-512 (F, BW, DQ and VL) and BMI2.
    pub fn avx512() -> Option<Self> {
        Self::wide(wide::Vectors::Avx512)
    }

    /// This machine with vectors of 256 bits, 64-bit x86; `None` unless its processor has AVX2, BMI1 and BMI2.
    pub fn avx2() -> Option<Self> {
        Self::wide(wide::Vectors::Avx2)
    }

    fn wide(vectors: wide::Vectors) -> Option<Self> {
        vectors.are_available().then_some(Self {
            code: Generator::Wide(vectors),
            checked: false,
        })
    }

    /// The same with all of the code generator's internal checks switched on. Compiling takes several times as long.
    ///
    /// # Errors
    /// As [`Self::host`].
    pub fn checked(self) -> Result<Self, Error> {
        let checked = true;
        let code = match self.code {
            Generator::Narrow(_) => Generator::Narrow(narrow::host(checked)?),
            Generator::Wide(vectors) => Generator::Wide(vectors),
        };
        Ok(Self { code, checked })
    }

    /// The machine and its processor's features, as code must name them in order to run here.
    pub fn description(&self) -> String {
        match &self.code {
            Generator::Narrow(machine) => machine.description(),
            Generator::Wide(vectors) => vectors.description(),
        }
    }

    /// Numbers of lanes that code can be compiled for, in ascending order.
    pub fn lanes(&self) -> &'static [u32] {
        match self.code {
            Generator::Narrow(_) => &narrow::NUMBERS,
            Generator::Wide(vectors) => vectors.numbers(),
        }
    }

    /// Most words of a buffer that code can reach.
    pub fn reach(&self) -> u32 {
        match self.code {
            Generator::Narrow(_) => u32::MAX,
            // Vectors of indices have signs.
            Generator::Wide(_) => i32::MAX as u32,
        }
    }

    /// The most lanes for which a thread's stack has room, as far as this can be computed before code is generated.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if there is none for any number.
    pub fn most_lanes(&self, trees: &Trees) -> Result<u32, Error> {
        let values = most_at_once(trees);
        let fits = |lanes: &u32| {
            let bytes = u64::from(*lanes) * values * size_of::<u32>() as u64;
            check_arrays(trees, *lanes).is_ok() && bytes <= FRAME
        };
        let most = self.lanes().iter().copied().rfind(fits);
        most.ok_or(Error::TooLarge)
    }

    /// Compiles a program for the given number of lanes.
    ///
    /// # Errors
    /// [`Error::Lanes`], [`Error::Arrays`], [`Error::TooLarge`] or [`Error::Backend`].
    pub fn compile(&self, trees: &Trees, lanes: u32) -> Result<Code, Error> {
        if !self.lanes().contains(&lanes) {
            return Err(Error::Lanes(lanes, self.lanes()));
        }
        check_arrays(trees, lanes)?;
        let bytes = match &self.code {
            Generator::Narrow(machine) => machine.compile(trees, lanes)?,
            Generator::Wide(vectors) => vectors.compile(trees, lanes, self.checked)?,
        };
        Ok(Code {
            lanes,
            reach: self.reach(),
            target: self.description(),
            strides: trees.strides.clone(),
            bytes,
        })
    }
}

/// Words of the longest element of any buffer.
fn longest_element(trees: &Trees) -> u32 {
    trees.strides.iter().max().copied().unwrap_or(1)
}
