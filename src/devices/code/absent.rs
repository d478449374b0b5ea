//! Stands in for ways to run kernels that this build doesn't have: code compiled at run time without the feature `native` or
//! on processors that it can't be generated for, and the interpreter without the feature `compose`.

use oneiro_shaders::{Kernel, Words};

use crate::evaluator::Error;

/// No lane code has this name.
#[allow(dead_code, reason = "of code compiled at run time nobody asks it")]
pub(crate) const NAME: &str = "";

/// Code; there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Code {}

#[allow(dead_code, reason = "of code compiled at run time nobody asks it")]
pub(crate) fn is_available() -> bool {
    false
}

#[allow(dead_code, reason = "of the interpreter nobody asks it")]
pub(crate) fn all() -> impl Iterator<Item = (&'static str, u32)> {
    std::iter::empty()
}

#[allow(dead_code, reason = "of the interpreter nobody asks it")]
pub(crate) fn named(_: &'static Kernel, _: &str) -> Option<Result<Code, Error>> {
    None
}

#[allow(dead_code, reason = "of the interpreter nobody asks it")]
pub(crate) fn best(kernel: &'static Kernel) -> Result<Code, Error> {
    compiled(kernel)
}

pub(crate) fn compiled(kernel: &'static Kernel) -> Result<Code, Error> {
    let kernel = kernel.name;
    Err(Error::NoDevice(format!(
        "this program can't run the kernel {kernel}, which is composed at run time"
    )))
}

#[allow(dead_code, reason = "of the interpreter nobody asks it")]
pub(crate) fn problem(_: &'static Kernel) -> Option<String> {
    None
}

#[allow(dead_code, reason = "of code compiled at run time nobody asks it")]
pub(crate) fn checked(kernel: &'static Kernel) -> Result<Code, Error> {
    compiled(kernel)
}

impl Code {
    pub(crate) fn name(self) -> &'static str {
        match self {}
    }

    pub(crate) fn lanes(self) -> u32 {
        match self {}
    }

    pub(crate) unsafe fn run(self, _: &[Words], _: u32, _: u32, _: u64) -> Result<(), Error> {
        match self {}
    }
}
