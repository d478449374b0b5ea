//! Runs single operations and functions of the kernels. Tests and `oneiro device test` compare their results between
//! devices, bit by bit. The kernels are in `shaders/wgsl/probe/`.

mod functions;
mod operations;

use std::fmt;

use oneiro_shaders::{Kernel, Words};

use crate::devices::code::{LaneCode, interpreter};

pub use functions::functions;
pub use operations::operations;

/// One dispatch of a probe kernel: an operation or a function, and the operands to test it with.
///
/// Its buffers, in the order of the kernel's bindings: [`parameters`](Self::parameters), [`left`](Self::left),
/// [`right`](Self::right), and one word per result. f32 operands and results are given by their bits; 0 has one sign.
#[derive(Clone, Debug)]
pub struct Case {
    /// Kernel that computes it.
    pub kernel: &'static Kernel,
    /// Operation or function that it computes.
    pub subject: Subject,
    /// First buffer of the kernel.
    pub parameters: [u32; 4],
    /// First operands, x.
    pub left: Vec<u32>,
    /// Second operands, y, as many as first ones even if they aren't used.
    pub right: Vec<u32>,
}

/// Operation or function of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// An operation.
    Operation {
        /// Type of its operands.
        scalar: Scalar,
        /// Expression in WGSL with operands x and y, such as `x + y`.
        text: &'static str,
        /// Which operand is a constant in the kernel, if any.
        form: Form,
    },
    /// A function by its name in the kernels' library; `cosine` and `sine` are the two values of `cosine_sine`.
    Function(&'static str),
}

/// Type of an operation's operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// Numbers.
    F32,
    /// Signed integers, modulo 2^32.
    I32,
    /// Unsigned integers, modulo 2^32.
    U32,
    /// The lowest bit of a word.
    Bool,
}

/// Which operand is a constant in the kernel, where compilers can fold it. The case's operands include it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// None.
    Open,
    /// The right one.
    Right(i8),
    /// The left one.
    Left(i8),
}

impl Case {
    /// Number of workgroups that compute the case.
    pub fn workgroups(&self) -> u32 {
        (self.left.len() as u32).div_ceil(self.kernel.workgroup_size)
    }

    /// Names of the lane codes that this processor can run, and of the interpreter.
    pub fn lane_codes(&self) -> impl Iterator<Item = &'static str> + use<> {
        LaneCode::all(self.kernel).map(|(name, _)| name).chain(interpreter())
    }

    /// Computes the case on this processor with the named lane code; `None` if the processor can't run it, or if its loops don't
    /// end where they must.
    pub fn run(&self, lane_code: &str) -> Option<Vec<u32>> {
        let code = LaneCode::named(self.kernel, lane_code).ok()??;
        let mut results = vec![0; self.left.len()];
        let buffers = [
            read(&self.parameters),
            read(&self.left),
            read(&self.right),
            Words {
                start: results.as_mut_ptr(),
                len: results.len(),
            },
        ];
        let size = self.kernel.workgroup_size;
        let turns = (self.kernel.turns.0)(&|_: &str, _: Option<u64>, _: u32| u32::MAX);
        // Idle lanes aren't run.
        for first in (0..self.left.len() as u32).step_by(code.lanes() as usize) {
            // SAFETY: the buffers are those of the bindings of both probe kernels, and not empty; only the last is written,
            // by one call at a time.
            unsafe { code.run(&buffers, first / size, first % size, turns) }.ok()?;
        }
        Some(results)
    }
}

/// A buffer that kernels only read.
fn read(words: &[u32]) -> Words {
    Words {
        start: words.as_ptr().cast_mut(),
        len: words.len(),
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (scalar, text, form) = match self {
            Self::Function(name) => return f.write_str(name),
            Self::Operation { scalar, text, form } => (scalar, text, form),
        };
        let scalar = match scalar {
            Scalar::F32 => "f32",
            Scalar::I32 => "i32",
            Scalar::U32 => "u32",
            Scalar::Bool => "bool",
        };
        write!(f, "{scalar}: {text}")?;
        match form {
            Form::Open => Ok(()),
            Form::Right(y) => write!(f, ", y = {y}"),
            Form::Left(x) => write!(f, ", x = {x}"),
        }
    }
}
