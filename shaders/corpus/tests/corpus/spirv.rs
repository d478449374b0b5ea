//! The SPIR-V of the kernels that ship and of the corpus.

use oneiro_shader_compiler::spirv::{decorated, float_arithmetic};
use oneiro_shader_corpus::CASES;
use oneiro_shaders::KERNELS;

#[test]
fn every_float_result_is_decorated() {
    let kernels = KERNELS.iter().copied().chain(CASES.iter().map(|case| case.kernel));
    let mut results = 0;
    for kernel in kernels {
        let decorated = decorated(kernel.spirv);
        for id in float_arithmetic(kernel.spirv) {
            assert!(decorated.contains(&id), "{}: %{id} may be contracted", kernel.name);
            results += 1;
        }
    }
    assert!(results > 100, "only {results} float results");
}
