//! The corpus' lane code on every instruction set of this machine: the same bits as the interpreter.

use oneiro_shader_corpus::{CASES, CONTROLS, Case};

#[test]
fn every_variant_does_what_the_program_means() {
    let mut run = Vec::new();
    for case in CASES {
        for variant in case.kernel.variants.iter().filter(|variant| (variant.available)()) {
            let differences = case.differences(&case.run(case.kernel, variant));
            assert!(
                differences.is_empty(),
                "{} on {}: {} words differ, the first of them (binding, word, found, expected) {:x?}",
                case.kernel.name,
                variant.name,
                differences.len(),
                differences[0],
            );
            if !run.contains(&variant.name) {
                run.push(variant.name);
            }
        }
    }
    eprintln!("{} kernels on {}", CASES.len(), run.join(", "));
    // Machine code made at run time, with the vectors of x86, has tests in its own package.
    let expected = if cfg!(target_arch = "aarch64") { 2 } else { 1 };
    assert_eq!(run.len(), expected, "{run:?}");
    assert!(
        !cfg!(target_arch = "aarch64") || run.contains(&"neonx16"),
        "NEON did not run"
    );
}

#[test]
fn a_changed_constant_is_seen() {
    let control = CONTROLS
        .iter()
        .find(|control| control.kernel.name == "changed")
        .expect("it is there");
    let case = Case::of(control.exact).expect("it is there");
    for variant in control.kernel.variants.iter().filter(|variant| (variant.available)()) {
        let differences = case.differences(&case.run(control.kernel, variant));
        assert!(
            !differences.is_empty(),
            "{} on {} is not seen",
            control.mistake,
            variant.name
        );
    }
}
