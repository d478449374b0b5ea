//! Stands in for code with vectors of 512 bits where there is none.

use oneiro_shader_compiler::Trees;

use crate::Error;

pub(crate) const NUMBERS: [u32; 0] = [];

pub(crate) fn is_available() -> bool {
    false
}

pub(crate) fn description() -> String {
    String::new()
}

pub(crate) fn compile(_: &Trees, _: u32, _: bool) -> Result<Vec<u8>, Error> {
    unreachable!("it is not available")
}
