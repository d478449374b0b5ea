//! Compiles the corpus and finds, with the interpreter, what each of its kernels must leave in the buffers.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

use oneiro_shader_compiler::instances::{self, Target};
use oneiro_shader_compiler::interpret::{Memory, run_invocation};
use oneiro_shader_compiler::{Compiled, Indices, Part, compile, generate, spirv, trees};

/// The hand-written kernels.
const WRITTEN: [&str; 14] = [
    "nested",
    "returns",
    "continuing",
    "pointers",
    "locals",
    "switches",
    "indices",
    "logic",
    "folding",
    "ordinary",
    "functions",
    "matrices",
    "turns",
    "chosen",
];
/// How many random kernels there are.
const RANDOM: usize = 24;
/// Workgroups of each dispatch.
const WORKGROUPS: u32 = 2;
/// Which float operations of `folding` are the products of `(x * 0.1f) * 0.3f`. Mesa reassociates what may be
/// contracted as a whole only, so for it to show, both must have lost their decoration.
const CONSTANT_PRODUCTS: [usize; 2] = [0, 1];

fn main() {
    let wgsl = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("wgsl");
    println!("cargo::rerun-if-changed={}", wgsl.display());
    let mut corpus = Corpus {
        out: PathBuf::from(env::var("OUT_DIR").expect("cargo sets it")),
        targets: targets(),
        items: String::new(),
        cases: String::new(),
    };
    for name in WRITTEN {
        if let Err(problem) = corpus.case(name, &read(&wgsl, name), 0) {
            panic!("{problem}");
        }
    }
    let mut seed = 0;
    let mut found = 0;
    while found < RANDOM {
        seed += 1;
        // Some are refused, run too long, or return at once.
        if corpus
            .case(&format!("random_{seed}"), &generate::kernel(seed, 40), seed)
            .is_ok()
        {
            found += 1;
        }
    }
    let controls = corpus.controls(&read(&wgsl, "folding"));
    let text = format!(
        "use oneiro_shaders::kernel::{{Binding, BindingKind, Kernel}};\n{items}\n\
         /// Workgroups of each dispatch.\npub const WORKGROUPS: u32 = {WORKGROUPS};\n\
         /// Every kernel.\npub static CASES: &[Case] = &[{cases}];\n\
         /// Kernels that differ from the first of theirs by one mistake.\npub static CONTROLS: &[Control] = &[{controls}];\n",
        items = corpus.items,
        cases = corpus.cases,
    );
    fs::write(corpus.out.join("corpus.rs"), text).expect("OUT_DIR is writable");
}

fn read(wgsl: &Path, name: &str) -> String {
    let path = wgsl.join(format!("{name}.wgsl"));
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All lanes except the checked ones, which would stop where a kernel reads beyond the end of a buffer.
fn targets() -> Vec<Target> {
    let unchecked = |target: &&Target| target.name != "checked";
    instances::TARGETS.iter().filter(unchecked).copied().collect()
}

struct Corpus {
    out: PathBuf,
    targets: Vec<Target>,
    items: String,
    cases: String,
}

fn parts(name: &str, text: &str) -> [Part; 2] {
    let part = |path: &str, text: &str| Part {
        path: path.to_owned(),
        text: text.to_owned(),
    };
    [part("prelude", generate::PRELUDE), part(name, text)]
}

impl Corpus {
    /// Adds a kernel and its buffers before and after.
    fn case(&mut self, name: &str, text: &str, seed: u64) -> Result<(), String> {
        let parts = parts(name, text);
        let trees = trees(&parts).map_err(|refusals| refusals[0].to_string())?;
        let before = generate::buffers(seed, WORKGROUPS);
        let mut after = before.clone();
        let mut memory = Memory {
            buffers: &mut after,
            strides: &trees.strides,
        };
        for invocation in 0..WORKGROUPS * generate::WORKGROUP {
            let (workgroup, lane) = (invocation / generate::WORKGROUP, invocation % generate::WORKGROUP);
            run_invocation(&trees.raw, &mut memory, workgroup, lane, true).map_err(|trap| format!("{name}: {trap}"))?;
        }
        let changed = before.iter().flatten().zip(after.iter().flatten());
        let changed = changed.filter(|(before, after)| before != after).count();
        if changed < (WORKGROUPS * generate::WORKGROUP) as usize {
            return Err(format!("{name} changes only {changed} words"));
        }
        let kernel = compile(name, &parts, Indices::Clamped).expect("its program was made above");
        self.add(name, &kernel);
        let constant = name.to_uppercase();
        let _ = writeln!(
            self.cases,
            "Case {{ kernel: &{constant}, before: &{before:?}, after: &{after:?} }},",
            before = before.iter().map(Borrowed).collect::<Vec<_>>(),
            after = after.iter().map(Borrowed).collect::<Vec<_>>(),
        );
        Ok(())
    }

    /// The kernel `folding` with mistakes.
    fn controls(&mut self, text: &str) -> String {
        let changed = text.replacen("0.3f", &format!("{:?}f", 0.3_f32.next_up()), 1);
        assert_ne!(changed, text, "folding.wgsl has no constant 0.3f");
        let compiled = |name: &str, text: &str| {
            compile(name, &parts(name, text), Indices::Clamped).expect("`folding` was compiled")
        };
        let changed = compiled("changed", &changed);
        let mut contracted = compiled("contracted", text);
        contracted.spirv = spirv::without_contraction(&contracted.spirv, &CONSTANT_PRODUCTS);
        let mut list = String::new();
        for (name, kernel, mistake) in [
            ("changed", changed, "a constant is changed by one ulp"),
            ("contracted", contracted, "two products may be contracted"),
        ] {
            self.add(name, &kernel);
            let _ = writeln!(
                list,
                "Control {{ mistake: \"{mistake}\", kernel: &{}, exact: &FOLDING }},",
                name.to_uppercase()
            );
        }
        list
    }

    fn add(&mut self, name: &str, kernel: &Compiled) {
        let items = instances::write(&self.out, "oneiro_shaders", name, kernel, &self.targets);
        self.items += &items.expect("OUT_DIR is writable");
    }
}

/// Prints as a borrowed slice.
struct Borrowed<'a>(&'a Vec<u32>);

impl std::fmt::Debug for Borrowed<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "&{:?}", self.0)
    }
}
