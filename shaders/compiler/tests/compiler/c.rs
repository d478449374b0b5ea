//! Random kernels as C leave the same bits as in the interpreter, by every compiler and with every optimisation.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs, process};

use oneiro_shader_compiler::interpret::{self, Trap, run_invocation};
use oneiro_shader_compiler::language::{self, Memory};
use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::tree::Program;
use oneiro_shader_compiler::{Generic, Part, c, generate};

use crate::seeds::unless_refused;
use crate::skips::skipped;

const LANES: u32 = 4;
const WORKGROUP: u32 = 1;

/// Compilers, and how they are called. A processor with fused instructions is none that all have: that the files of controllers keep compilers
/// from using them is tested with those.
const COMPILERS: [(&str, &[&str]); 6] = [
    ("gcc", &["-O0"]),
    ("gcc", &["-O2", "-std=c99"]),
    ("gcc", &["-O3"]),
    ("clang", &["-O0", "-std=c99"]),
    ("clang", &["-O1"]),
    ("clang", &["-O3"]),
];
/// All warnings but those of comparisons that always come out alike: random kernels have many.
const QUIET: [&str; 7] = [
    "-Wall",
    "-Wextra",
    "-pedantic",
    "-Wshadow",
    "-Werror",
    "-Wno-type-limits",
    "-Wno-tautological-compare",
];

/// A folder that is removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("oneiro-c-{name}-{}", process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A kernel, its buffers before it runs, and after.
struct Case {
    function: String,
    before: Vec<Vec<u32>>,
    after: Vec<Vec<u32>>,
}

fn run_interpreted(program: &Program, strides: &[u32], mut buffers: Vec<Vec<u32>>) -> Result<Vec<Vec<u32>>, Trap> {
    let mut memory = interpret::Memory {
        buffers: &mut buffers,
        strides,
    };
    for lane in 0..LANES {
        run_invocation(program, &mut memory, WORKGROUP, lane, true)?;
    }
    Ok(buffers)
}

/// A random kernel as a C function, specialised to its constants if `seed` is even.
fn case(seed: u64) -> Option<Case> {
    let text = generate::kernel(seed, 20 + (seed % 80) as u32);
    let part = |path: &str, text: &str| Part {
        path: path.into(),
        text: text.into(),
    };
    let parts = [part("prelude", generate::PRELUDE), part("kernel", &text)];
    let generic = unless_refused(seed, &text, Generic::new(&parts))?;
    let before = generate::buffers(seed, WORKGROUP + 1);
    let strides: Vec<_> = generic.bindings.iter().map(|binding| binding.stride / 4).collect();
    let after = match run_interpreted(generic.any(), &strides, before.clone()) {
        Ok(after) => after,
        Err(Trap::Endless) => return None,
        Err(trap) => panic!("seed {seed}: {trap}\n{text}"),
    };
    let word = |buffer: u32, element: Option<u32>, offset: u32| {
        let at = buffer as usize;
        let is_array = before[at].len() as u32 > strides[at];
        if seed % 2 == 1 || generic.bindings[at].kind == "ReadWrite" || (is_array && element.is_none()) {
            return None;
        }
        let last = before[at].len() as u32 / strides[at] - 1;
        Some(before[at][(element.unwrap_or(0).min(last) * strides[at] + offset) as usize])
    };
    let program = generic.alone(generic.program(&Known {
        word: &word,
        signed_zeros: true,
    }));
    let memory: Vec<_> = (before.iter().zip(&strides).enumerate())
        .map(|(number, (words, stride))| Memory::Words(format!("b[{number}]"), words.len() as u32 / stride))
        .collect();
    let function = format!(
        "static void kernel_{seed}(uint32_t *const *b, uint32_t workgroup, uint32_t lane)\n{{\n    (void)b;\n    (void)workgroup;\n    \
         (void)lane;\n{}}}\n",
        language::print(&program, &c::C, &memory, 1)
    );
    Some(Case {
        function,
        before,
        after,
    })
}

/// A program that reads the buffers of all kernels, runs these, and writes the buffers.
fn file(cases: &[(u64, Case)]) -> String {
    let functions: String = cases.iter().map(|(_, case)| case.function.as_str()).collect();
    let mut main = "int main(void)\n{\n    uint32_t *b[8];\n    uint32_t lane, i;\n".to_owned();
    for (seed, case) in cases {
        let sizes: Vec<_> = case.before.iter().map(|words| words.len().to_string()).collect();
        let _ = writeln!(
            main,
            "    {{
        static const size_t sizes[8] = {{{}}};
        for (i = 0; i < 8; i++) {{
            b[i] = malloc(4 * sizes[i]);
            if (fread(b[i], 4, sizes[i], stdin) != sizes[i]) return 1;
        }}
        for (lane = 0; lane < {LANES}; lane++) kernel_{seed}(b, {WORKGROUP}, lane);
        for (i = 0; i < 8; i++) {{
            if (fwrite(b[i], 4, sizes[i], stdout) != sizes[i]) return 1;
            free(b[i]);
        }}
    }}",
            sizes.join(", ")
        );
    }
    main += "    return 0;\n}\n";
    let helpers = c::helpers(&functions);
    format!(
        "#include <stdio.h>\n#include <stdlib.h>\n{}\n{helpers}\n{functions}{main}",
        c::PREAMBLE
    )
}

/// Compiles a file, and runs it.
fn run(folder: &Path, compiler: &str, options: &[&str], text: &str, input: &[u8]) -> Vec<u8> {
    let (source, program) = (folder.join("kernels.c"), folder.join("kernels"));
    fs::write(&source, text).expect("the file is written");
    let compiled = Command::new(compiler)
        .args(QUIET)
        .args(options)
        .args([source.as_os_str(), "-o".as_ref(), program.as_os_str()])
        .output()
        .expect("the compiler runs");
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{compiler} {options:?}: {messages}");
    let mut child = Command::new(&program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program runs");
    let mut stdin = child.stdin.take().expect("it is piped");
    let output = std::thread::scope(|scope| {
        scope.spawn(move || stdin.write_all(input));
        child.wait_with_output().expect("it ends")
    });
    assert!(output.status.success(), "{compiler} {options:?}: {}", output.status);
    output.stdout
}

/// Seeds of kernels that leave other bits as C, if `change` is made to their code.
fn differing(
    folder: &Folder,
    cases: &[(u64, Case)],
    (compiler, options): (&str, &[&str]),
    change: fn(String) -> String,
) -> Vec<u64> {
    let words = |of: fn(&Case) -> &Vec<Vec<u32>>| -> Vec<u8> {
        let all = cases.iter().flat_map(|(_, case)| of(case).iter().flatten());
        all.flat_map(|word| word.to_ne_bytes()).collect()
    };
    let before = words(|case| &case.before);
    let found = run(&folder.0, compiler, options, &change(file(cases)), &before);
    let expected = words(|case| &case.after);
    assert_eq!(found.len(), expected.len());
    let mut begin = 0;
    let differs = |(seed, case): &(u64, Case)| {
        let end = begin + 4 * case.after.iter().map(Vec::len).sum::<usize>();
        let is_same = found[begin..end] == expected[begin..end];
        begin = end;
        (!is_same).then_some(*seed)
    };
    cases.iter().filter_map(differs).collect()
}

#[test]
fn kernels_as_c_do_what_the_program_means() {
    let is_long = env::var_os("ONEIRO_LONG").is_some();
    let kernels = if is_long { 4000 } else { 40 };
    let cases: Vec<_> = (0..kernels).filter_map(|seed| Some((seed, case(seed)?))).collect();
    assert!(cases.len() as u64 > kernels / 2, "{} of {kernels} kernels", cases.len());
    let folder = Folder::new("same");
    for (compiler, options) in COMPILERS {
        if Command::new(compiler).arg("--version").output().is_err() {
            skipped("compilers", &format!("random kernels as C by {compiler}"));
            continue;
        }
        for cases in cases.chunks(100) {
            let differing = differing(&folder, cases, (compiler, options), |text| text);
            assert!(
                differing.is_empty(),
                "{compiler} {options:?}: seeds {differing:?} differ"
            );
        }
    }
}

#[test]
fn a_mistake_in_c_is_seen() {
    if Command::new("gcc").arg("--version").output().is_err() {
        skipped("compilers", "mistakes in C by gcc");
        return;
    }
    let cases: Vec<_> = (0..10).filter_map(|seed| Some((seed, case(seed)?))).collect();
    for change in [
        |text: String| text.replace(" ^ ", " | "),
        |text: String| text.replace(" >> ", " << "),
    ] {
        let differing = differing(
            &Folder::new("mistaken"),
            &cases,
            ("gcc", &["-O0", "-Wno-error"]),
            change,
        );
        assert!(!differing.is_empty());
    }
}
