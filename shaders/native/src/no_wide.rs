//! Stands in for code with vectors of 256 and 512 bits where there is none.

use oneiro_shader_compiler::Trees;

use crate::Error;

#[derive(Clone, Copy)]
pub(crate) enum Vectors {
    Avx2,
    Avx512,
}

impl Vectors {
    pub(crate) fn are_available(self) -> bool {
        false
    }

    pub(crate) fn description(self) -> String {
        String::new()
    }

    pub(crate) fn numbers(self) -> &'static [u32] {
        &[]
    }

    pub(crate) fn compile(self, _: &Trees, _: u32, _: bool) -> Result<Vec<u8>, Error> {
        unreachable!("it is not available")
    }
}
