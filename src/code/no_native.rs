//! Stands in for machine code compiled at run time in builds without the feature `native`, and on processors that code
//! can't be generated for.

use oneiro_shaders::{Kernel, Words};

use crate::evaluator::Error;

/// No lane code has this name.
pub(crate) const NAME: &str = "";
pub(crate) const LANES: u32 = 1;

/// Code; there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Code {}

pub(crate) fn is_available() -> bool {
    false
}

pub(crate) fn compiled(kernel: &'static Kernel) -> Result<Code, Error> {
    let kernel = kernel.name;
    Err(Error::NoDevice(format!(
        "{kernel} can't be compiled at run time in this program"
    )))
}

impl Code {
    pub(crate) fn lanes(self) -> u32 {
        match self {}
    }

    pub(crate) unsafe fn run(self, _: &[Words], _: u32, _: u32) {
        match self {}
    }
}
