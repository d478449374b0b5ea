//! The shader compiler's corpus on a GPU has the same bits as in its interpreter and its lane code, and mistakes in the
//! SPIR-V are detected. These tests need an adapter: without one they fail.
#![cfg(feature = "gpu")]

use oneiro::gpu::{Choice, FloatControls, Gpu};
use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::{Generic, Indices, Part};
use oneiro_shader_corpus::{CASES, CONTROLS, Case, WORKGROUPS};
use oneiro_shaders::{BindingKind, Kernel};

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

/// A case's kernel, of whose constant words a share in four is known beforehand.
fn specialised(case: &Case, share: u32) -> Kernel {
    let part = Part {
        path: case.kernel.name.into(),
        text: case.kernel.wgsl.into(),
    };
    let generic = Generic::new(&[part]).unwrap_or_else(|refusals| panic!("{refusals:?}"));
    let contents = case.buffers();
    let word = |buffer: u32, element: Option<u32>, offset: u32| {
        let binding = &case.kernel.bindings[buffer as usize];
        let (words, stride) = (&contents[buffer as usize], binding.stride as usize / 4);
        let is_array = binding.kind != BindingKind::Uniform;
        if binding.kind == BindingKind::ReadWrite || (is_array && element.is_none()) {
            return None;
        }
        let element = (element.unwrap_or(0) as usize).min(words.len() / stride - 1);
        let index = element * stride + offset as usize;
        (index as u32 % 4 < share).then(|| words[index])
    };
    let program = generic.program(&Known {
        word: &word,
        signed_zeros: true,
    });
    let spirv = generic.spirv(&program, Indices::Clamped);
    Kernel {
        spirv: Vec::leak(spirv.unwrap_or_else(|problem| panic!("{}: {problem}", case.kernel.name))),
        ..*case.kernel
    }
}

#[test]
fn specialised_kernels_do_what_the_program_means() {
    let mut gpu = gpu();
    for case in CASES {
        for share in [0, 2, 4] {
            let differences = differences(&mut gpu, &specialised(case, share), case);
            assert!(
                differences.is_empty(),
                "{} with {share} of 4 words known: {} words differ, the first of them (binding, word, found, expected) {:x?}",
                case.kernel.name,
                differences.len(),
                differences[0],
            );
        }
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
