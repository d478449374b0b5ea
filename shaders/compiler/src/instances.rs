//! Writes a compiled kernel as Rust source: its lane function, an instance of it for each instruction set and number of
//! lanes, and the `Kernel` that lists them.

use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

use crate::{Binding, Bound, Compiled};

/// An instruction set, and the number of lanes for which code is compiled.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// `cfg` of the architecture.
    pub arch: &'static str,
    /// First part of its variant's name.
    pub name: &'static str,
    /// Features that the processor must have, if that is known only at run time.
    pub features: &'static [&'static str],
    /// Vectors side by side, and lanes per vector.
    pub shape: (u32, u32),
    /// Type of one vector, in `oneiro_shaders::lanes`.
    pub vector: &'static str,
}

/// Instruction sets. On x86, code with vectors is compiled at run time.
pub const TARGETS: &[Target] = &[
    Target {
        arch: "target_arch = \"aarch64\"",
        name: "neon",
        features: &["neon"],
        shape: (4, 4),
        vector: "Neon",
    },
    Target {
        arch: "all(target_arch = \"wasm32\", target_feature = \"simd128\")",
        name: "simd128",
        features: &[],
        shape: (4, 4),
        vector: "Simd128",
    },
    Target {
        arch: "all()",
        name: "scalar",
        features: &[],
        shape: (1, 1),
        vector: "Scalar",
    },
    Target {
        arch: "all()",
        name: "checked",
        features: &[],
        shape: (1, 1),
        vector: "Checked",
    },
];

/// Writes a kernel's forms to files in a build's output folder, and returns Rust items that include them: a static `Kernel`
/// with the kernel's name in upper case. `library` is the path of `oneiro_shaders` as seen from those items.
///
/// # Errors
/// Errors of the file system.
pub fn write(
    out: &Path,
    library: &str,
    name: &str,
    kernel: &Compiled,
    targets: &[Target],
) -> Result<String, io::Error> {
    let words: Vec<_> = kernel.spirv.iter().map(|word| format!("{word:#x}")).collect();
    fs::write(out.join(format!("{name}.wgsl")), &kernel.wgsl)?;
    fs::write(
        out.join(format!("{name}.lanes.rs")),
        lanes(library, name, &kernel.lanes, targets),
    )?;
    fs::write(out.join(format!("{name}.spv.rs")), format!("&[{}]", words.join(",")))?;
    Ok(format!(
        "/// The kernel `{name}`.\npub static {constant}: Kernel = Kernel {{\n\
         name: \"{name}\",\nparts: &{parts:?},\n\
         wgsl: include_str!(concat!(env!(\"OUT_DIR\"), \"/{name}.wgsl\")),\n\
         spirv: include!(concat!(env!(\"OUT_DIR\"), \"/{name}.spv.rs\")),\n\
         entry_point: \"main\",\nworkgroup_size: {},\nbindings: &[{}],\nvariants: {name}_lanes::VARIANTS,\n\
         turns: {library}::kernel::Turns(&{turns}),\n}};\n\
         #[allow(clippy::all, clippy::pedantic, unused, unused_comparisons, unsafe_op_in_unsafe_fn, reason = \"generated\")]\n\
         mod {name}_lanes {{ include!(concat!(env!(\"OUT_DIR\"), \"/{name}.lanes.rs\")); }}\n",
        kernel.workgroup_size,
        kernel.bindings.iter().map(Binding::as_rust).collect::<String>(),
        parts = kernel.parts,
        constant = name.to_uppercase(),
        turns = kernel.turns.as_ref().map_or_else(|_| "|_| u64::MAX".to_owned(), turns),
    ))
}

/// Writes a closure that returns the upper bound of the turns of a kernel's loops.
fn turns(bound: &Bound) -> String {
    let expression = bound.as_rust();
    let word = if expression.contains("word(") { "word" } else { "_" };
    format!("|{word}| {expression}")
}

/// Writes a kernel's lane function and its instances as Rust items. `VARIANTS` lists the instances, and tests at run time
/// whether the processor has the features that they need.
fn lanes(library: &str, name: &str, function: &str, targets: &[Target]) -> String {
    let mut text = format!("use {library}::kernel::{{Variant, Words}};\nuse {library}::lanes::*;\n");
    text.push_str(function);
    let mut list = String::new();
    for target in targets {
        let (count, width) = target.shape;
        let lanes = count * width;
        let instance = format!("{name}_{}x{lanes}", target.name);
        let pairs = count.ilog2() as usize;
        let ty = format!("{}{}{}", "Pair<".repeat(pairs), target.vector, ">".repeat(pairs));
        let enable = if target.features.is_empty() {
            String::new()
        } else {
            format!("#[target_feature(enable = \"{}\")]\n", target.features.join(","))
        };
        let test = |feature: &&str| format!("std::arch::is_aarch64_feature_detected!(\"{feature}\")");
        let available = if target.features.is_empty() {
            "true".to_owned()
        } else {
            target.features.iter().map(test).collect::<Vec<_>>().join(" && ")
        };
        let _ = writeln!(
            text,
            "#[cfg({arch_cfg})]\n{enable}unsafe fn {instance}(b: &[Words], w: u32, l: u32) {{\n\
             align_frame::<{vector}>();\n{name}::<{ty}>(b, w, l)\n}}",
            arch_cfg = target.arch,
            vector = target.vector,
        );
        let _ = writeln!(
            list,
            "#[cfg({})] Variant {{ name: \"{}x{lanes}\", lanes: {lanes}, available: || {available}, run: {instance} }},",
            target.arch, target.name,
        );
    }
    let _ = writeln!(text, "pub(crate) static VARIANTS: &[Variant] = &[\n{list}];");
    text
}
