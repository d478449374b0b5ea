//! Emulated processors, which run controllers as C.

use std::fs;
use std::path::Path;
use std::process::Command;

use oneiro::export::Recorded;
use rayon::prelude::*;

use super::{Folder, Subject, compile};
use crate::skips::skipped;

/// A processor: how files are compiled for it, and how its program is run.
pub(crate) struct Chip {
    pub(crate) name: &'static str,
    pub(crate) compile: &'static [&'static str],
    board: Board,
    pub(crate) run: &'static [&'static str],
    /// Bytes of recorded cycles for which there is room.
    room: usize,
    /// Whether `tests/all.sh` tries it.
    is_usual: bool,
}

/// The kind of machine that runs a program.
#[derive(Clone, Copy, PartialEq)]
enum Board {
    Cortex,
    Avr,
    RiscV,
    WebAssembly,
}

pub(crate) const CORTEX: &[&str] = &[
    "-mthumb",
    "-Os",
    "-nostartfiles",
    "--specs=nosys.specs",
    "-T",
    "cortex.ld",
    "cortex.c",
];
const RISC_V: &[&str] = &[
    "-O2",
    "-nostdlib",
    "-mcmodel=medany",
    "-ffreestanding",
    "-T",
    "riscv.ld",
    "riscv.c",
    "memory.c",
];
pub(crate) const QEMU: &[&str] = &["-nographic", "-monitor", "none", "-serial", "none"];

pub(crate) const CHIPS: [Chip; 9] = [
    Chip {
        name: "Cortex-M0",
        compile: &["arm-none-eabi-gcc", "-mcpu=cortex-m0"],
        board: Board::Cortex,
        run: &["qemu-system-arm", "-M", "microbit"],
        room: 150_000,
        is_usual: true,
    },
    Chip {
        name: "Cortex-M3",
        compile: &["arm-none-eabi-gcc", "-mcpu=cortex-m3"],
        board: Board::Cortex,
        run: &["qemu-system-arm", "-M", "mps2-an385"],
        room: 150_000,
        is_usual: false,
    },
    Chip {
        name: "Cortex-M4F",
        compile: &[
            "arm-none-eabi-gcc",
            "-mcpu=cortex-m4",
            "-mfpu=fpv4-sp-d16",
            "-mfloat-abi=hard",
        ],
        board: Board::Cortex,
        run: &["qemu-system-arm", "-M", "mps2-an386"],
        room: 150_000,
        is_usual: true,
    },
    Chip {
        name: "Cortex-M7",
        compile: &[
            "arm-none-eabi-gcc",
            "-mcpu=cortex-m7",
            "-mfpu=fpv5-sp-d16",
            "-mfloat-abi=hard",
        ],
        board: Board::Cortex,
        run: &["qemu-system-arm", "-M", "mps2-an500"],
        room: 150_000,
        is_usual: false,
    },
    Chip {
        name: "ATmega328P",
        compile: &["avr-gcc", "-mmcu=atmega328p", "-Os", "avr.c"],
        board: Board::Avr,
        run: &["simavr", "-m", "atmega328p", "-f", "16000000"],
        room: 1_000,
        is_usual: true,
    },
    Chip {
        name: "RV32IMAC",
        compile: &["riscv64-unknown-elf-gcc", "-march=rv32imac", "-mabi=ilp32"],
        board: Board::RiscV,
        run: &["qemu-system-riscv32", "-M", "virt", "-bios", "none"],
        room: 2_000_000,
        is_usual: false,
    },
    Chip {
        name: "RV32IMAFC",
        compile: &["riscv64-unknown-elf-gcc", "-march=rv32imafc", "-mabi=ilp32f"],
        board: Board::RiscV,
        run: &["qemu-system-riscv32", "-M", "virt", "-bios", "none"],
        room: 2_000_000,
        is_usual: false,
    },
    Chip {
        name: "RV64IMAFDC",
        compile: &["riscv64-unknown-elf-gcc", "-march=rv64imafdc", "-mabi=lp64d"],
        board: Board::RiscV,
        run: &["qemu-system-riscv64", "-M", "virt", "-bios", "none"],
        room: 2_000_000,
        is_usual: false,
    },
    Chip {
        name: "WebAssembly",
        compile: &[
            "clang",
            "--target=wasm32",
            "-O2",
            "-nostdlib",
            "-Wl,--no-entry",
            "-Wl,--export=run",
            "-ffreestanding",
            "memory.c",
        ],
        board: Board::WebAssembly,
        run: &["node", "wasm.mjs"],
        room: 2_000_000,
        is_usual: false,
    },
];

/// Files of boards.
const FILES: [(&str, &str); 7] = [
    ("memory.c", include_str!("../microcontrollers/memory.c")),
    ("cortex.c", include_str!("../microcontrollers/cortex.c")),
    ("cortex.ld", include_str!("../microcontrollers/cortex.ld")),
    ("avr.c", include_str!("../microcontrollers/avr.c")),
    ("riscv.c", include_str!("../microcontrollers/riscv.c")),
    ("riscv.ld", include_str!("../microcontrollers/riscv.ld")),
    ("wasm.mjs", include_str!("../microcontrollers/wasm.mjs")),
];

impl Chip {
    /// A tool that it needs and that isn't there.
    pub(crate) fn missing(&self) -> Option<&str> {
        let is_missing = |tool: &&str| Command::new(tool).arg("--version").output().is_err();
        [self.compile[0], self.run[0]].into_iter().find(is_missing)
    }

    /// The result of a controller's check; none if its program is too large.
    pub(crate) fn check(&self, folder: &Path, name: &str) -> Option<u32> {
        let main =
            format!("int {name}_check(void);\nint run(void);\nint run(void)\n{{\n    return {name}_check();\n}}\n");
        fs::write(folder.join("run.c"), main).unwrap();
        let [compiler, options @ ..] = self.compile else {
            unreachable!()
        };
        let of_board = match self.board {
            Board::Cortex => CORTEX,
            Board::RiscV => RISC_V,
            Board::Avr | Board::WebAssembly => &[],
        };
        // Functions for floats by software, and for copies of structs, come last.
        let libraries: &[&str] = if self.board == Board::RiscV { &["-lgcc"] } else { &[] };
        let files = ["run.c".to_owned(), format!("{name}.c")];
        let files: Vec<_> = files
            .into_iter()
            .chain(libraries.iter().map(|library| (*library).to_owned()))
            .collect();
        let compiled = compile(
            folder,
            compiler,
            &[options, of_board, &["-o", "program"]].concat(),
            &files,
        );
        let messages = String::from_utf8_lossy(&compiled.stderr);
        if !compiled.status.success() && messages.contains("region") {
            return None;
        }
        assert!(compiled.status.success(), "{}: {messages}", self.name);
        let [program, arguments @ ..] = self.run else {
            unreachable!()
        };
        let more: &[&[&str]] = match self.board {
            Board::Cortex => &[QEMU, &["-semihosting", "-kernel", "program"]],
            Board::RiscV => &[QEMU, &["-kernel", "program"]],
            Board::Avr => &[&["program"]],
            Board::WebAssembly => &[],
        };
        let mut command = Command::new(program);
        let command = command.args(arguments).args(more.concat()).current_dir(folder);
        let output = command.output().unwrap();
        if self.board != Board::Avr {
            return Some(output.status.code().unwrap() as u32);
        }
        // simavr shows what the program writes to its serial port, in a colour.
        let shown = [output.stdout, output.stderr].concat();
        let shown = String::from_utf8_lossy(&shown).into_owned();
        let line = shown
            .lines()
            .rev()
            .find_map(|line| line.rsplit_once("[32m")?.1.split('.').next()?.parse().ok());
        Some(line.unwrap_or_else(|| panic!("{}: {shown}", self.name)))
    }

    /// Cycles of a controller that there is room for.
    pub(crate) fn cycles(&self, cycle: &Recorded) -> usize {
        let numbers = 2 * cycle.before.words().len() + cycle.readings.len() + cycle.outputs.len();
        self.room / (4 * numbers)
    }
}

pub(crate) fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    for (file, text) in FILES {
        fs::write(folder.0.join(file), text).unwrap();
    }
    folder
}

/// The chips whose tools are there.
pub(crate) fn chips(are_all: bool) -> Vec<&'static Chip> {
    let wanted = CHIPS.iter().filter(|chip| are_all || chip.is_usual);
    let is_there = |chip: &&Chip| match chip.missing() {
        Some(tool) => {
            let untested = format!("controllers as C on a {}, for want of {tool}", chip.name);
            skipped("microcontrollers", &untested);
            false
        }
        None => true,
    };
    wanted.filter(is_there).collect()
}

/// Compares so many cycles of controllers on all chips. The AVR chip is emulated in real time, so it gets a few dozen cycles; some
/// controllers are too large for it. `ONEIRO_CHIP` is a part of the names of those to try.
pub(crate) fn compared_on_all(what: &str, subjects: &[Subject], count: usize) {
    let one = std::env::var("ONEIRO_CHIP").unwrap_or_default();
    let chips: Vec<_> = chips(true)
        .into_iter()
        .filter(|chip| chip.name.contains(&one))
        .collect();
    chips.par_iter().for_each(|chip| {
        let folder = folder(&format!("{what}-{}", chip.name));
        let (mut controllers, mut cycles, mut too_large) = (0, 0, Vec::new());
        for subject in subjects {
            let Subject { name, cycles: all, .. } = subject;
            let (room, wanted) = (
                chip.cycles(&all[0]),
                if chip.board == Board::Avr { 4 } else { usize::MAX },
            );
            let mut fits = true;
            for (number, part) in all[..count].chunks(room).take(wanted).enumerate() {
                subject.write(&folder.0, part);
                match chip.check(&folder.0, name) {
                    Some(found) => assert_eq!(found, 0, "{name} on a {}, part {number} of {room}", chip.name),
                    None => fits = false,
                }
                cycles += if fits { part.len() } else { 0 };
            }
            controllers += u32::from(fits);
            if !fits {
                too_large.push(name.as_str());
            }
        }
        assert!(
            chip.board == Board::Avr || too_large.is_empty(),
            "{}: {too_large:?}",
            chip.name
        );
        println!(
            "{}: {controllers} controllers, {cycles} cycles; too large: {too_large:?}",
            chip.name
        );
    });
}
