//! Code that runs.

use crate::executable::Executable;
use crate::{Code, Error, Target};

/// A buffer of 32-bit words, as the code sees it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Words {
    /// First word.
    pub start: *mut u32,
    /// Number of words.
    pub len: usize,
}

/// Reasons why a call stopped early, or didn't begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// Its loops used up this budget of turns.
    #[error("the kernel's loops turned {0} times, and had not ended")]
    TurnsUsedUp(u64),
    /// The number of buffers isn't the kernel's.
    #[error("the kernel binds {expected} buffers, and was given {found}")]
    Buffers {
        /// Number that it binds.
        expected: usize,
        /// Number that it was given.
        found: usize,
    },
    /// A buffer is shorter than one element, or longer than an index can reach.
    #[error("buffer {binding} has {words} words; allowed: {least} to {most}")]
    Size {
        /// Binding number of the buffer.
        binding: usize,
        /// Number of its words.
        words: usize,
        /// Words of one element.
        least: u32,
        /// Most words that the code can reach.
        most: u32,
    },
}

/// Code that is ready to run, from several threads at a time.
#[derive(Debug)]
pub struct Native {
    executable: Executable,
    lanes: u32,
    reach: u32,
    strides: Vec<u32>,
}

impl Native {
    /// Makes code executable.
    ///
    /// # Errors
    /// [`Error::Foreign`] if it was compiled for another machine, [`Error::Memory`] if the system provides none.
    pub fn new(code: &Code) -> Result<Self, Error> {
        let machine = Target::host()?.description();
        let is_code_of = |target: Option<Target>| target.is_some_and(|target| target.description() == code.target);
        if code.target != machine && !is_code_of(Target::avx512()) && !is_code_of(Target::avx2()) {
            let code = code.target.clone();
            return Err(Error::Foreign { code, machine });
        }
        Ok(Self {
            executable: Executable::new(&code.bytes)?,
            lanes: code.lanes,
            reach: code.reach,
            strides: code.strides.clone(),
        })
    }

    /// Number of invocations that a call runs.
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    /// Runs invocations `first_lane..first_lane + lanes` of one workgroup. Their loops may take `turns` turns in all.
    ///
    /// # Errors
    /// See [`Stopped`]. A call that uses up its turns leaves the buffers half written.
    ///
    /// # Safety
    /// Every buffer must be valid for reads for its whole length, and those that the kernel writes also for writes. While a
    /// call runs, no other may access the words that it writes.
    pub unsafe fn run(&self, buffers: &[Words], workgroup: u32, first_lane: u32, turns: u64) -> Result<(), Stopped> {
        if buffers.len() != self.strides.len() {
            return Err(Stopped::Buffers {
                expected: self.strides.len(),
                found: buffers.len(),
            });
        }
        for (binding, (buffer, &least)) in buffers.iter().zip(&self.strides).enumerate() {
            let (words, most) = (buffer.len, self.reach);
            if words < least as usize || words > most as usize {
                return Err(Stopped::Size {
                    binding,
                    words,
                    least,
                    most,
                });
            }
        }
        // SAFETY: all buffers that the code reads are there, each with at least one element, and the code clamps every
        // index into its buffer. The caller guarantees that they are valid.
        match unsafe { self.executable.run(buffers, workgroup, first_lane, turns) } {
            0 => Ok(()),
            _ => Err(Stopped::TurnsUsedUp(turns)),
        }
    }
}

#[cfg(test)]
mod tests {
    use oneiro_shader_compiler::{Part, trees};

    use super::*;

    #[test]
    fn code_for_another_machine_is_refused() {
        let part = Part {
            path: "empty.wgsl".into(),
            text: "@compute @workgroup_size(64) fn main() {}".into(),
        };
        let target = Target::host().expect("this machine has machine code");
        let mut code = target
            .compile(&trees(&[part]).expect("it is exact"), 4)
            .expect("it compiles");
        assert!(Native::new(&code).is_ok());
        code.target = code.target.replacen('-', "-other-", 1);
        let error = Native::new(&code).unwrap_err();
        assert!(matches!(error, Error::Foreign { .. }), "{error}");
    }

    /// Callers can turn it into their errors.
    #[test]
    fn reasons_are_errors() {
        fn boxed(stopped: Stopped) -> Box<dyn std::error::Error + Send + Sync> {
            stopped.into()
        }
        let message = boxed(Stopped::TurnsUsedUp(7)).to_string();
        assert_eq!(message, "the kernel's loops turned 7 times, and had not ended");
    }
}
