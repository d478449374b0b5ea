//! Compiles the kernels of `wgsl/`. The catalogue is the place to add one.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

use oneiro_shader_compiler::instances::{self, TARGETS, Target};
use oneiro_shader_compiler::{Compiled, Constant, Part, compile};

/// A kernel: its constant's name, the module of its host structs, its parts, and whether its lane code is compiled for
/// several vectors at a time too. That pays where a life is small enough for the registers; elsewhere it gains a few
/// percent or loses, and takes longest to compile (`docs/measurements.md`).
struct Entry {
    name: &'static str,
    module: &'static str,
    parts: &'static [&'static str],
    wide: bool,
}

/// A life: its physics are those of the simulator made from samples, or of what stands in for the robot itself.
macro_rules! life {
    ($name:literal, sampled, $controller:literal) => {
        life!($name, "life", true, $controller, "robot/differential", "sensor/sampled", "physics/sliding", "physics/sampled")
    };
    ($name:literal, surrogate, $controller:literal) => {
        life!($name, "surrogate", false, $controller, "lib/individual", "physics/sliding", "robot/wheels", "sensor/rays", "physics/surrogate")
    };
    ($name:literal, $module:literal, $wide:literal, $controller:literal, $($physics:literal),+) => {
        Entry {
            name: $name,
            module: $module,
            parts: &[
                "lib/numerics",
                "lib/random",
                "lib/geometry",
                "lib/batch",
                "lib/rollout",
                "robot/motors",
                "sensor/readings",
                $controller,
                "task/avoidance",
                $($physics,)+
                "life",
            ],
            wide: $wide,
        }
    };
}

/// The catalogue of kernels: one part a slot (robot, sensor, physics, controller, task).
const CATALOGUE: &[Entry] = &[
    life!("life_perceptron", sampled, "controller/perceptron"),
    life!("life_hidden", sampled, "controller/hidden"),
    life!("life_recurrent", sampled, "controller/recurrent"),
    life!("surrogate_perceptron", surrogate, "controller/perceptron"),
    life!("surrogate_hidden", surrogate, "controller/hidden"),
    life!("surrogate_recurrent", surrogate, "controller/recurrent"),
    Entry {
        name: "forager",
        module: "forager",
        parts: &[
            "lib/numerics",
            "lib/random",
            "lib/batch",
            "lib/rollout",
            "lib/forager",
            "lib/circle",
            "lib/food",
            "sensor/epuck",
            "robot/epuck_alone",
            "robot/epuck",
            "controller/behaviours",
            "task/foraging",
            "physics/foraging",
            "life",
        ],
        wide: false,
    },
    Entry {
        name: "swarm",
        module: "swarm",
        parts: &[
            "lib/numerics",
            "lib/random",
            "lib/batch",
            "lib/forager",
            "lib/circle",
            "lib/swarm",
            "lib/food",
            "sensor/epuck",
            "robot/epuck_among",
            "robot/epuck",
            "controller/behaviours",
            "task/shared_foraging",
            "physics/arena",
            "swarm",
        ],
        wide: false,
    },
    Entry {
        name: "probe_numerics",
        module: "probe_numerics",
        parts: &["lib/numerics", "lib/random", "probe/buffers", "probe/numerics"],
        wide: true,
    },
    Entry {
        name: "probe_operations",
        module: "probe_operations",
        parts: &["probe/buffers", "probe/operations"],
        wide: true,
    },
];

fn main() {
    let wgsl = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("wgsl");
    println!("cargo::rerun-if-changed={}", wgsl.display());
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    let mut text = String::from("use crate::kernel::{Binding, BindingKind, Kernel};\n");
    let mut modules: Vec<(&str, String)> = Vec::new();
    // Kernels of a module have parts in common, and constants with them.
    let mut constants: BTreeMap<&str, Vec<Constant>> = BTreeMap::new();
    let mut failed = false;
    for entry in CATALOGUE {
        match compile(entry.name, &parts(&wgsl, entry)).and_then(Compiled::bounded) {
            Ok(kernel) => {
                let items = instances::write(&out, "crate", entry.name, &kernel, &targets(entry));
                text.push_str(&items.expect("OUT_DIR is writable"));
                match modules.iter().find(|(name, _)| *name == entry.module) {
                    Some((_, structs)) => assert_eq!(
                        *structs, kernel.structs,
                        "the kernels of module {} disagree about its structs",
                        entry.module
                    ),
                    None => modules.push((entry.module, kernel.structs)),
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
fn add_constants(all: &mut Vec<Constant>, own: &[Constant], module: &str) {
    for constant in own {
        match all.iter().find(|other| other.name == constant.name) {
            Some(other) => assert_eq!(other.item, constant.item, "the kernels of module {module} disagree"),
            None => all.push(constant.clone()),
        }
    }
}

/// What an entry is compiled for: each target's shapes, or only its narrowest.
fn targets(entry: &Entry) -> Vec<Target> {
    let narrowest = |target: &Target| Target {
        shapes: &target.shapes[target.shapes.len() - 1..],
        ..*target
    };
    if entry.wide {
        TARGETS.to_vec()
    } else {
        TARGETS.iter().map(narrowest).collect()
    }
}

fn parts(wgsl: &Path, entry: &Entry) -> Vec<Part> {
    let read = |name: &&str| {
        let path = format!("{name}.wgsl");
        let text = fs::read_to_string(wgsl.join(&path)).unwrap_or_else(|error| panic!("wgsl/{path}: {error}"));
        Part { path, text }
    };
    entry.parts.iter().map(read).collect()
}
