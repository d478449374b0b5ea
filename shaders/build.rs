//! Compiles the kernels of `wgsl/`. `catalogue.rs` is the place to add one.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::{env, fs};

use oneiro_shader_compiler::instances::{self, TARGETS, Target};
use oneiro_shader_compiler::{Compiled, Constant, Indices, compile};

#[path = "catalogue.rs"]
mod catalogue;
use catalogue::{CATALOGUE, parts};

fn main() {
    // The parts are in this program.
    println!("cargo::rerun-if-changed=build.rs");
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    let mut text = String::from("use crate::kernel::{Binding, BindingKind, Kernel};\n");
    let mut modules: Vec<(&str, String)> = Vec::new();
    // Kernels of a module have parts in common, and constants with them.
    let mut constants: BTreeMap<&str, Vec<Constant>> = BTreeMap::new();
    let mut failed = false;
    for entry in CATALOGUE {
        let compiled = compile(entry.name, &parts(entry), Indices::Within).and_then(Compiled::bounded);
        match compiled.and_then(|kernel| Ok((kernel.structs.clone()?, kernel))) {
            Ok((structs, mut kernel)) => {
                if !has("SPIRV") {
                    kernel.spirv.clear();
                }
                if !has("WGSL") {
                    kernel.wgsl.clear();
                }
                let items = instances::write(&out, "crate", entry.name, &kernel, &targets());
                text.push_str(&items.expect("OUT_DIR is writable"));
                match modules.iter().find(|(name, _)| *name == entry.module) {
                    Some((_, others)) => assert_eq!(
                        *others, structs,
                        "the kernels of module {} disagree about its structs",
                        entry.module
                    ),
                    None => modules.push((entry.module, structs)),
                }
                add_constants(
                    constants.entry(entry.module).or_default(),
                    &kernel.constants,
                    entry.module,
                );
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
            "/// Constants of the `{name}` kernels, and host structs of their buffers.\npub mod {name} {{\n{structs}{}}}",
            constants[name]
                .iter()
                .map(|constant| constant.item.as_str())
                .collect::<String>(),
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

/// Adds a kernel's constants to its module's.
fn add_constants(all: &mut Vec<Constant>, constants: &[Constant], module: &str) {
    for constant in constants {
        match all.iter().find(|other| other.name == constant.name) {
            Some(other) => assert_eq!(other.item, constant.item, "the kernels of module {module} disagree"),
            None => all.push(constant.clone()),
        }
    }
}

/// Whether a feature of this crate is enabled.
fn has(feature: &str) -> bool {
    env::var_os(format!("CARGO_FEATURE_{feature}")).is_some()
}

/// What lane code is compiled for.
fn targets() -> Vec<Target> {
    let is_wanted = |target: &&Target| target.name != "checked" || has("CHECKED");
    TARGETS.iter().filter(is_wanted).copied().collect()
}
