//! Shared by these tests: kernels run by the interpreter and as machine code.

use std::fs;
use std::path::Path;

use oneiro_shader_compiler::interpret::{Memory, Trap, run_invocation};
use oneiro_shader_compiler::{Part, Refusals, Trees, generate, trees};
use oneiro_shader_native::{Native, Stopped, Target, Words};

/// More loop turns than any of these kernels takes.
pub(crate) const TURNS: u64 = 1_000_000;

/// The program of a kernel that follows the generator's prelude.
pub(crate) fn program(text: &str) -> Result<Trees, Refusals> {
    let part = |path: &str, text: &str| Part {
        path: path.into(),
        text: text.into(),
    };
    trees(&[part("prelude", generate::PRELUDE), part("kernel", text)])
}

/// Workgroups and lanes of a run.
#[derive(Clone, Debug)]
pub(crate) struct Extent {
    pub(crate) workgroups: std::ops::Range<u32>,
    pub(crate) lanes: u32,
}

impl Extent {
    /// Workgroup and first lane of each call, if a call runs `lanes` lanes.
    pub(crate) fn calls(&self, lanes: u32) -> impl Iterator<Item = (u32, u32)> {
        let all = self.lanes;
        self.workgroups
            .clone()
            .flat_map(move |workgroup| (0..all).step_by(lanes as usize).map(move |first| (workgroup, first)))
    }
}

/// Buffers after the program, as the interpreter runs it: one invocation at a time.
pub(crate) fn meaning(trees: &Trees, mut buffers: Vec<Vec<u32>>, extent: &Extent) -> Result<Vec<Vec<u32>>, Trap> {
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    for (workgroup, lane) in extent.calls(1) {
        run_invocation(&trees.raw, &mut memory, workgroup, lane, true)?;
    }
    Ok(buffers)
}

/// The processors that this machine has code for.
pub(crate) fn targets() -> Vec<Target> {
    let host = Target::host().expect("this machine has machine code");
    let wide = [Target::avx512(), Target::avx2()];
    wide.into_iter().flatten().chain([host]).collect()
}

/// A program's machine code by each code generator and for each number of lanes. That of the fewest lanes, which is short, is compiled
/// with all internal checks.
pub(crate) fn natives(trees: &Trees) -> Vec<Native> {
    let mut natives = Vec::new();
    for target in targets() {
        let [fewest, more @ ..] = target.lanes() else {
            panic!("there is no number of lanes")
        };
        natives.extend(more.iter().map(|lanes| native(&target, trees, *lanes)));
        natives.push(native(&target.checked().expect("it was there"), trees, *fewest));
    }
    natives
}

/// A program's machine code.
pub(crate) fn native(target: &Target, trees: &Trees, lanes: u32) -> Native {
    let code = target.compile(trees, lanes).expect("it compiles");
    Native::new(&code).expect("there is memory")
}

/// Buffers after machine code has run.
pub(crate) fn run(
    native: &Native,
    mut buffers: Vec<Vec<u32>>,
    extent: &Extent,
    turns: u64,
) -> Result<Vec<Vec<u32>>, Stopped> {
    let words: Vec<_> = buffers
        .iter_mut()
        .map(|buffer| Words {
            start: buffer.as_mut_ptr(),
            len: buffer.len(),
        })
        .collect();
    for (workgroup, first) in extent.calls(native.lanes()) {
        // SAFETY: the buffers are whole, and used by this call only.
        unsafe { native.run(&words, workgroup, first, turns) }?;
    }
    Ok(buffers)
}

/// The shader compiler's hand-written kernels, by name.
pub(crate) fn corpus() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus/wgsl");
    let files = fs::read_dir(folder).expect("the corpus is there");
    let read = |path: &Path| {
        let name = path.file_stem().expect("it has a name").to_string_lossy();
        (name.into_owned(), fs::read_to_string(path).expect("it is text"))
    };
    let mut corpus: Vec<_> = files
        .map(|file| read(&file.expect("it can be listed").path()))
        .collect();
    corpus.sort();
    corpus
}
