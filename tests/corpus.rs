//! The shader compiler's corpus on a GPU has the same bits as in its interpreter and its lane code, and mistakes in the
//! SPIR-V are detected. These tests need an adapter: without one they fail.
#![cfg(feature = "gpu")]

use oneiro::gpu::{Choice, FloatControls, Gpu};
use oneiro_shader_corpus::{CASES, CONTROLS, Case, WORKGROUPS};
use oneiro_shaders::Kernel;

fn gpu() -> Gpu {
    Gpu::open(&Choice::Best).expect("these tests need an adapter")
}

/// Positions where a kernel's buffers differ from the expected ones of a case.
fn differences(gpu: &mut Gpu, kernel: &Kernel, case: &Case) -> Vec<(usize, usize, u32, u32)> {
    let mut buffers = case.buffers();
    gpu.run_kernel(kernel, &mut buffers, WORKGROUPS)
        .unwrap_or_else(|error| panic!("{}: {error}", kernel.name));
    case.differences(&buffers)
}

#[test]
fn every_kernel_does_what_the_program_means() {
    assert!(!CASES.is_empty());
    let mut gpu = gpu();
    for case in CASES {
        let differences = differences(&mut gpu, case.kernel, case);
        assert!(
            differences.is_empty(),
            "{}: {} words differ, the first of them (binding, word, found, expected) {:x?}",
            case.kernel.name,
            differences.len(),
            differences[0],
        );
    }
}

#[test]
fn mistakes_are_seen() {
    let mut gpu = gpu();
    // Some drivers that have these modes don't contract while the modes are on.
    gpu.ask_for(FloatControls::default());
    assert!(!CONTROLS.is_empty());
    for control in CONTROLS {
        let case = Case::of(control.exact).expect("a control's exact kernel is a case");
        assert!(differences(&mut gpu, control.exact, case).is_empty());
        assert!(
            !differences(&mut gpu, control.kernel, case).is_empty(),
            "{} is not seen",
            control.mistake
        );
    }
}
