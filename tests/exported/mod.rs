//! Controllers as C, for tests that compare them with their simulator: by compilers here, and on [other processors](chips).

pub(crate) mod chips;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{env, fs, process};

use oneiro::cpu::Cpu;
use oneiro::export::{Controller, Recorded, c};
use oneiro::random::Key;
use oneiro::world::World;

use crate::skips::skipped;

/// Compilers, and how they are called: all optimisations, as C99 and by default. Those after the usual ones only in `tests/long.sh`.
const COMPILERS: [(&str, &[&str]); 17] = [
    ("gcc", &["-O0"]),
    ("gcc", &["-O2", "-std=c99"]),
    ("gcc", &["-O3"]),
    ("clang", &["-O2"]),
    // As C++.
    ("g++", &["-O1", "-x", "c++"]),
    ("gcc", &["-O0", "-std=c99"]),
    ("gcc", &["-O1"]),
    ("gcc", &["-O1", "-std=c99"]),
    ("gcc", &["-O2"]),
    ("gcc", &["-O3", "-std=c99"]),
    ("clang", &["-O0"]),
    ("clang", &["-O0", "-std=c99"]),
    ("clang", &["-O1"]),
    ("clang", &["-O1", "-std=c99"]),
    ("clang", &["-O2", "-std=c99"]),
    ("clang", &["-O3"]),
    ("clang", &["-O3", "-std=c99"]),
];
const USUAL: usize = 5;
pub(crate) const QUIET: [&str; 7] = [
    "-Wall",
    "-Wextra",
    "-pedantic",
    "-Wshadow",
    "-Wmissing-declarations",
    "-Wconversion",
    "-Werror",
];

/// A controller, and cycles of its episodes in the simulator.
pub(crate) struct Subject {
    pub(crate) name: String,
    pub(crate) controller: Controller,
    pub(crate) cycles: Vec<Recorded>,
}

impl Subject {
    /// The controller of a world's robot, and at least so many cycles of at least three episodes.
    pub(crate) fn new(name: String, world: &World, genome: &[f32], robot: u32, count: usize) -> Self {
        let mut cpu = Cpu::new(Some(2)).unwrap();
        let controller = Controller::new(world, genome, robot).unwrap_or_else(|invalid| panic!("{name}: {invalid}"));
        let mut cycles = Vec::new();
        for trial in 0..10_000 {
            if trial >= 3 && cycles.len() >= count {
                break;
            }
            let episode = controller.record(&mut cpu, Key::rollout(3, 0, 0, trial));
            cycles.extend(episode.unwrap_or_else(|error| panic!("{name}: {error}")));
        }
        assert!(cycles.len() >= count.max(100), "{name}: {} cycles", cycles.len());
        Self {
            name,
            controller,
            cycles,
        }
    }

    /// Writes it as C, with some of its cycles to check.
    pub(crate) fn write(&self, folder: &Path, cycles: &[Recorded]) {
        let origin = ["a test /* of */ comments".to_owned()];
        let text = c(&self.controller, &self.name, &origin, cycles);
        fs::write(folder.join(format!("{}.c", self.name)), text).unwrap();
    }
}

/// A folder that is removed in the end.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("oneiro-export-{name}-{}", process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub(crate) fn is_there(compiler: &str) -> bool {
    let is_there = Command::new(compiler).arg("--version").output().is_ok();
    if !is_there {
        skipped("compilers", &format!("controllers as C by {compiler}"));
    }
    is_there
}

pub(crate) fn compile(folder: &Path, compiler: &str, options: &[&str], files: &[String]) -> Output {
    let mut command = Command::new(compiler);
    command.args(options).args(files).current_dir(folder).output().unwrap()
}

/// Numbers of the first cycles that differ, by controller; 0 where none does.
pub(crate) fn checked(folder: &Path, compiler: &str, options: &[&str], names: &[&str]) -> Vec<u32> {
    let mut main = "#include <stdio.h>\n".to_owned();
    for name in names {
        let _ = writeln!(main, "int {name}_check(void);");
    }
    main += "int main(void)\n{\n";
    for name in names {
        let _ = writeln!(main, "    printf(\"%d\\n\", {name}_check());");
    }
    main += "    return 0;\n}\n";
    fs::write(folder.join("main.c"), main).unwrap();
    let files: Vec<_> = ["main"].iter().chain(names).map(|name| format!("{name}.c")).collect();
    let compiled = compile(
        folder,
        compiler,
        &[&QUIET[..], options, &["-o", "checks"]].concat(),
        &files,
    );
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{compiler} {options:?}: {messages}");
    let output = Command::new(folder.join("checks")).output().unwrap();
    assert!(output.status.success(), "{compiler} {options:?}: {}", output.status);
    let lines = String::from_utf8(output.stdout).unwrap();
    lines.lines().map(|line| line.parse().unwrap()).collect()
}

/// Compares all cycles of controllers by every compiler.
pub(crate) fn compared_here(what: &str, subjects: &[Subject]) {
    let folder = Folder::new(what);
    for subject in subjects {
        subject.write(&folder.0, &subject.cycles);
    }
    let names: Vec<_> = subjects.iter().map(|subject| subject.name.as_str()).collect();
    let is_long = env::var_os("ONEIRO_LONG").is_some();
    let tried = if is_long { COMPILERS.len() } else { USUAL };
    for (compiler, options) in &COMPILERS[..tried] {
        if is_there(compiler) {
            let differing = checked(&folder.0, compiler, options, &names);
            assert_eq!(differing, vec![0; names.len()], "{compiler} {options:?} of {names:?}");
        }
    }
    let cycles: usize = subjects.iter().map(|subject| subject.cycles.len()).sum();
    println!("{} controllers, {cycles} cycles, by {tried} compilers", names.len());
}
