//! Stands in for lane code that a Rust toolchain compiled in builds that don't load any.

use oneiro_shaders::{Kernel, Words};

/// Code; there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Code {}

pub(crate) fn problem(_: &'static Kernel) -> Option<String> {
    None
}

pub(crate) fn all(_: &'static Kernel) -> Vec<(&'static str, u32)> {
    Vec::new()
}

pub(crate) fn named(_: &'static Kernel, _: &str) -> Option<Code> {
    None
}

impl Code {
    pub(crate) fn lanes(self) -> u32 {
        match self {}
    }

    pub(crate) unsafe fn run(self, _: &[Words], _: u32, _: u32) {
        match self {}
    }
}
