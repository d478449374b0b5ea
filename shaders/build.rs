//! Compiles the kernels of `wgsl/`. The catalogue is the place to add one.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

use oneiro_shader_compiler::{Compiled, Part, compile};

/// A kernel: its constant's name, the module of its host structs, and its parts.
struct Entry {
    name: &'static str,
    module: &'static str,
    parts: &'static [&'static str],
}

/// What every life is made of besides its controller.
macro_rules! life {
    ($name:literal, $controller:literal) => {
        Entry {
            name: $name,
            module: "life",
            parts: &[
                "lib/numerics",
                "lib/random",
                "lib/geometry",
                "robot/differential",
                "sensor/sampled",
                $controller,
                "task/avoidance",
                "life",
            ],
        }
    };
}

/// The catalogue of kernels: one part a slot (robot, sensor, controller, task).
const CATALOGUE: &[Entry] = &[
    life!("life_perceptron", "controller/perceptron"),
    life!("life_hidden", "controller/hidden"),
    life!("life_recurrent", "controller/recurrent"),
];

fn main() {
    let wgsl = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("wgsl");
    println!("cargo::rerun-if-changed={}", wgsl.display());
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    let mut text = String::from("use crate::kernel::{Binding, BindingKind, Kernel};\n");
    let mut modules: Vec<(&str, String)> = Vec::new();
    let mut failed = false;
    for entry in CATALOGUE {
        match compile(entry.name, &parts(&wgsl, entry)) {
            Ok(kernel) => {
                write_kernel(&out, entry, &kernel, &mut text);
                match modules.iter().find(|(name, _)| *name == entry.module) {
                    Some((_, structs)) => assert_eq!(
                        *structs, kernel.structs,
                        "the kernels of module {} disagree about its structs",
                        entry.module
                    ),
                    None => modules.push((entry.module, kernel.structs)),
                }
            }
            Err(refusals) => {
                failed = true;
                for refusal in refusals {
                    println!("cargo::error={}: wgsl/{refusal}", entry.name);
                }
            }
        }
    }
    if failed {
        std::process::exit(1);
    }
    for (name, structs) in modules {
        let _ = writeln!(
            text,
            "/// Host structs of the buffers of `{name}` kernels.\npub mod {name} {{\n{structs}}}"
        );
    }
    let names: Vec<_> = CATALOGUE
        .iter()
        .map(|entry| format!("&{}", entry.name.to_uppercase()))
        .collect();
    let _ = writeln!(
        text,
        "/// Every kernel.\npub static KERNELS: &[&Kernel] = &[{}];",
        names.join(", ")
    );
    fs::write(out.join("kernels.rs"), text).expect("OUT_DIR is writable");
}

/// An instruction set: what code must be compiled for it and with which lanes.
struct Target {
    /// `cfg` of the architecture.
    arch: &'static str,
    name: &'static str,
    features: &'static [&'static str],
    /// Vectors side by side, lanes of one.
    shapes: &'static [(u32, u32)],
    vector: &'static str,
}

/// Widest first. The numbers of lanes were measured: see `docs/measurements.md`.
const TARGETS: &[Target] = &[
    Target {
        arch: "target_arch = \"x86_64\"",
        name: "avx512",
        features: &["avx512f", "avx512bw", "avx512dq", "avx512vl"],
        shapes: &[(4, 16), (1, 16)],
        vector: "Avx512",
    },
    Target {
        arch: "target_arch = \"x86_64\"",
        name: "avx2",
        features: &["avx2"],
        shapes: &[(2, 8)],
        vector: "Avx2",
    },
    Target {
        arch: "target_arch = \"x86_64\"",
        name: "sse41",
        features: &["sse4.1"],
        shapes: &[(4, 4)],
        vector: "Sse41",
    },
    Target {
        arch: "target_arch = \"aarch64\"",
        name: "neon",
        features: &["neon"],
        shapes: &[(4, 4)],
        vector: "Neon",
    },
    Target {
        arch: "all()",
        name: "scalar",
        features: &[],
        shapes: &[(1, 1)],
        vector: "Scalar",
    },
    Target {
        arch: "all()",
        name: "checked",
        features: &[],
        shapes: &[(1, 1)],
        vector: "Checked",
    },
];

/// A kernel's lane function and its instances with their run-time tests.
fn lanes(name: &str, function: &str) -> String {
    let mut text = String::from("use crate::kernel::{Variant, Words};\nuse crate::lanes::*;\n");
    text.push_str(function);
    let mut list = String::new();
    for target in TARGETS {
        for (count, width) in target.shapes {
            let lanes = count * width;
            let instance = format!("{name}_{}x{lanes}", target.name);
            let ty = if *count == 1 {
                target.vector.to_owned()
            } else {
                format!("Wide<{}, {count}>", target.vector)
            };
            let enable = if target.features.is_empty() {
                String::new()
            } else {
                format!("#[target_feature(enable = \"{}\")]\n", target.features.join(","))
            };
            let detect = if target.name == "neon" {
                "is_aarch64_feature_detected"
            } else {
                "is_x86_feature_detected"
            };
            let tests: Vec<_> = target
                .features
                .iter()
                .map(|feature| format!("std::arch::{detect}!(\"{feature}\")"))
                .collect();
            let available = if tests.is_empty() {
                "true".to_owned()
            } else {
                tests.join(" && ")
            };
            let _ = writeln!(
                text,
                "#[cfg({arch_cfg})]\n{enable}unsafe fn {instance}(b: &[Words], w: u32, l: u32) {{ {name}::<{ty}>(b, w, l) }}",
                arch_cfg = target.arch,
            );
            let _ = writeln!(
                list,
                "#[cfg({})] Variant {{ name: \"{}x{lanes}\", lanes: {lanes}, available: || {available}, run: {instance} }},",
                target.arch, target.name,
            );
        }
    }
    let _ = writeln!(text, "pub(crate) static VARIANTS: &[Variant] = &[\n{list}];");
    text
}

fn parts(wgsl: &Path, entry: &Entry) -> Vec<Part> {
    let read = |name: &&str| {
        let path = format!("{name}.wgsl");
        let text = fs::read_to_string(wgsl.join(&path)).unwrap_or_else(|error| panic!("wgsl/{path}: {error}"));
        Part { path, text }
    };
    entry.parts.iter().map(read).collect()
}

fn write_kernel(out: &Path, entry: &Entry, kernel: &Compiled, text: &mut String) {
    let Entry { name, .. } = entry;
    let words = kernel
        .spirv
        .iter()
        .map(|word| format!("{word:#x},"))
        .collect::<String>();
    fs::write(out.join(format!("{name}.wgsl")), &kernel.wgsl).expect("OUT_DIR is writable");
    fs::write(out.join(format!("{name}.lanes.rs")), lanes(name, &kernel.lanes)).expect("OUT_DIR is writable");
    fs::write(out.join(format!("{name}.spv.rs")), format!("&[{words}]")).expect("OUT_DIR is writable");
    let _ = writeln!(
        text,
        "/// The kernel `{name}`.\npub static {constant}: Kernel = Kernel {{\n\
         name: \"{name}\",\n\
         wgsl: include_str!(concat!(env!(\"OUT_DIR\"), \"/{name}.wgsl\")),\n\
         spirv: include!(concat!(env!(\"OUT_DIR\"), \"/{name}.spv.rs\")),\n\
         entry_point: \"main\",\nworkgroup_size: {},\nbindings: &[{}],\nvariants: {name}_lanes::VARIANTS,\n}};\n\
         #[allow(clippy::all, clippy::pedantic, unused, unsafe_op_in_unsafe_fn, reason = \"generated\")]\n\
         mod {name}_lanes {{ include!(concat!(env!(\"OUT_DIR\"), \"/{name}.lanes.rs\")); }}",
        kernel.workgroup_size,
        kernel.bindings,
        constant = name.to_uppercase(),
    );
}
