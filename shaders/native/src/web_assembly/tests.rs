use std::fmt::Write as _;
use std::io::Write;
use std::process::{Command, Stdio};

use oneiro_shader_compiler::interpret::{Memory, Trap, run_invocation};
use oneiro_shader_compiler::{Part, Trees, generate, trees};

use super::*;

/// A random kernel; none if the compiler refuses it.
fn kernel(seed: u64) -> Option<Trees> {
    let part = |path: &str, text: String| Part {
        path: path.into(),
        text,
    };
    let text = generate::kernel(seed, 20 + (seed % 80) as u32);
    trees(&[part("prelude", generate::PRELUDE.to_owned()), part("kernel", text)]).ok()
}

/// Buffers after the second workgroup of a kernel, as the interpreter runs it.
fn meaning(trees: &Trees, mut buffers: Vec<Vec<u32>>) -> Result<Vec<Vec<u32>>, Trap> {
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    for lane in 0..generate::WORKGROUP {
        run_invocation(&trees.raw, &mut memory, 1, lane, true)?;
    }
    Ok(buffers)
}

#[test]
fn modules_are_valid() {
    let mut bytes = 0;
    for trees in (0..60).filter_map(kernel) {
        for lanes in NUMBERS {
            let module = Machine.compile(&trees, lanes).expect("it is small");
            wasmparser::validate(&module).expect("it is valid");
            bytes += module.len();
        }
    }
    assert!(bytes > 100_000, "{bytes}");
}

/// Unused values and what only they need are left out, and a variable serves values that are not needed at the same time.
#[test]
fn local_variables_are_few() {
    let trees = (79..).find_map(kernel).expect("one is compiled");
    let mut asm = Wasm::new(&trees);
    emit(&mut asm, &trees, 16);
    let (locals, instructions) = asm.steps.written(&PARAMETERS);
    let vectors = 4 * trees.tidied.values.len();
    assert!(locals.len() < vectors / 2, "{} for {vectors}", locals.len());
    assert!(instructions.len() > vectors / 2, "{}", instructions.len());
}

/// Calls `run` of modules for all lanes of a workgroup, and compares the buffers with what they are to be. On standard input it takes a
/// line of JSON for each module.
const NODE: &str = "
const lines = require('fs').readFileSync(0, 'utf8').trim().split('\\n');
let differing = 0;
for (const line of lines) {
    const { seed, lanes, bytes, before, after } = JSON.parse(line);
    const memory = new WebAssembly.Memory({ initial: 64 });
    const words = new Uint32Array(memory.buffer);
    const [table, frame] = [256, 16384];
    let place = 262144;
    before.forEach((buffer, at) => {
        words.set([4 * place, 0, buffer.length, 0], table + 4 * at);
        words.set(buffer, place);
        place += buffer.length;
    });
    const module = new WebAssembly.Module(Uint8Array.from(bytes));
    const { run } = new WebAssembly.Instance(module, { oneiro: { memory } }).exports;
    let stopped = 0;
    for (let first = 0; first < 64; first += lanes) stopped |= run(4 * table, 1, first, 1000000n, 4 * frame);
    const expected = after.flat();
    const differs = stopped || expected.some((word, at) => word !== words[262144 + at]);
    if (differs) console.log(`seed ${seed}, ${lanes} lanes`);
    differing += differs;
}
console.log(`${lines.length} modules, ${differing} differ`);
";

#[test]
#[ignore = "needs node: tests/long.sh runs it"]
fn random_kernels_do_in_node_what_they_mean() {
    let mut cases = String::new();
    let mut count = 0;
    for (seed, trees) in (0..400).filter_map(|seed| Some((seed, kernel(seed)?))) {
        let before = generate::buffers(seed, 2);
        let Ok(after) = meaning(&trees, before.clone()) else {
            continue;
        };
        for lanes in NUMBERS {
            let bytes = Machine.compile(&trees, lanes).expect("it is small");
            writeln!(
                cases,
                "{{\"seed\":{seed},\"lanes\":{lanes},\"bytes\":{bytes:?},\"before\":{before:?},\"after\":{after:?}}}"
            )
            .expect("it is text");
            count += 1;
        }
    }
    assert!(count > 300, "{count}");
    let mut node = Command::new("node")
        .args(["-e", NODE])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("node runs");
    node.stdin
        .take()
        .expect("it is piped")
        .write_all(cases.as_bytes())
        .expect("node reads");
    let said = node.wait_with_output().expect("node ends");
    let said = String::from_utf8_lossy(&said.stdout);
    print!("{said}");
    assert!(said.ends_with(&format!("{count} modules, 0 differ\n")), "{said}");
}
