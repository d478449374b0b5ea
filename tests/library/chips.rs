//! Controllers as C on other processors, which are emulated: they have the simulator's bits, and GCC would fuse products without the file's
//! words. `tests/long.sh` tries all kinds of controllers, in 10,000 cycles each where the emulator is fast enough.

use std::fs;
use std::path::Path;
use std::process::Command;

use oneiro::automode::Modules;
use oneiro::cpu::Cpu;
use oneiro::export::{Controller, Recorded, c};
use oneiro::random::Key;
use oneiro::reference::{Model, Reference};
use oneiro::world::{self, World, WorldSpec};

use crate::epucks::epucks;
use crate::export::{Folder, Subject, compile, subjects_with, write_cycles};
use crate::skips::skipped;
use crate::{lives, modules};

/// A processor: how files are compiled for it, and how its program is run.
struct Chip {
    name: &'static str,
    compile: &'static [&'static str],
    board: Board,
    run: &'static [&'static str],
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

const CORTEX: &[&str] = &[
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
const QEMU: &[&str] = &["-nographic", "-monitor", "none", "-serial", "none"];

const CHIPS: [Chip; 9] = [
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
    fn missing(&self) -> Option<&str> {
        let is_missing = |tool: &&str| Command::new(tool).arg("--version").output().is_err();
        [self.compile[0], self.run[0]].into_iter().find(is_missing)
    }

    /// The result of a controller's check; none if its program is too large.
    fn check(&self, folder: &Path, name: &str) -> Option<u32> {
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
    fn cycles(&self, cycle: &Recorded) -> usize {
        let numbers = 2 * cycle.before.words().len() + cycle.readings.len() + cycle.outputs.len();
        self.room / (4 * numbers)
    }
}

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    for (file, text) in FILES {
        fs::write(folder.0.join(file), text).unwrap();
    }
    folder
}

/// The chips whose tools are there.
fn chips(are_all: bool) -> Vec<&'static Chip> {
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

#[test]
fn microcontrollers_have_the_simulators_bits() {
    let subjects = subjects_with(0);
    let folder = folder("chips");
    let (mut fused, chips) = (0, chips(false));
    for chip in &chips {
        for name in ["perceptron", "network_4", "machine"] {
            let subject = subjects.iter().find(|subject| subject.name == name).unwrap();
            let count = chip.cycles(&subject.cycles[0]).min(300);
            write_cycles(&folder.0, subject, &subject.cycles[..count]);
            assert_eq!(chip.check(&folder.0, name), Some(0), "{name} on a {}", chip.name);
            // By default GCC fuses products where it can.
            let path = folder.0.join(format!("{name}.c"));
            let text = fs::read_to_string(&path).unwrap();
            fs::write(&path, text.replace("#pragma GCC optimize", "#pragma message")).unwrap();
            fused += u32::from(chip.check(&folder.0, name) != Some(0));
        }
    }
    println!("{fused} have other bits without the file's words to the compiler");
    assert!(fused > 0 || chips.len() < 3);
}

/// Of each kind of controller. The AVR chip is emulated in real time, so it gets a few dozen cycles; some controllers are too
/// large for it. `ONEIRO_CHIP` is a part of the names of those to try.
#[test]
#[ignore = "emulates nine processors for ten minutes: tests/long.sh runs it"]
fn all_chips_have_the_simulators_bits_in_ten_thousand_cycles() {
    const CYCLES: usize = 10_000;
    let folder = folder("all-chips");
    let subjects = subjects_with(CYCLES);
    let one = std::env::var("ONEIRO_CHIP").unwrap_or_default();
    for chip in chips(true).into_iter().filter(|chip| chip.name.contains(&one)) {
        let (mut controllers, mut cycles, mut too_large) = (0, 0, Vec::new());
        for subject in &subjects {
            let Subject { name, cycles: all, .. } = subject;
            let (room, wanted) = (
                chip.cycles(&all[0]),
                if chip.board == Board::Avr { 4 } else { usize::MAX },
            );
            let mut fits = true;
            for (number, part) in all[..CYCLES].chunks(room).take(wanted).enumerate() {
                write_cycles(&folder.0, subject, part);
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
    }
}

/// Uses a controller without its check. Returns how many hundreds of instructions a cycle takes, by a timer of 16 MHz, at an instruction a
/// nanosecond.
const USED: &str = "#include <stdint.h>
#ifdef NAME
#include \"taken.c\"
#endif
volatile float given[64], taken[4];
#define REGISTER(address) (*(volatile uint32_t *)(address))
int run(void);
int run(void)
{
    float inputs[64], outputs[2] = {0.0f, 0.0f}, speeds[2] = {0.0f, 0.0f};
    uint32_t begin = 0u, end = 0u;
    int i;
    for (i = 0; i < 64; i++) {
        inputs[i] = given[i] + 0.3f;
    }
#ifdef NAME
    taken_state state;
    taken_reset(&state KEYS);
#ifdef COUNTED
    REGISTER(0x40008508u) = 3u;
    REGISTER(0x40008510u) = 0u;
    REGISTER(0x40008000u) = 1u;
    REGISTER(0x40008040u) = 1u;
    begin = REGISTER(0x40008540u);
    for (i = 0; i < 99; i++) {
        inputs[i % 8] = (float)i * 0.01f;
        taken_step(&state, inputs, outputs);
    }
    REGISTER(0x40008044u) = 1u;
    end = REGISTER(0x40008544u);
#endif
    taken_step(&state, inputs, outputs);
    taken_wheels(outputs, speeds);
#endif
    taken[0] = outputs[0] + inputs[3];
    taken[1] = outputs[1];
    taken[2] = speeds[0];
    taken[3] = speeds[1];
    /* An exit code is at most 255. */
    begin = (end - begin) * 125u / 2u / 99u / 100u;
    return begin < 255u ? (int)begin : 255;
}
";

/// A controller takes little of a Cortex-M4F's flash, and little of a Cortex-M0's time, 4.8 million instructions in a cycle.
#[test]
fn controllers_are_small_and_fast_enough() {
    let [m0, m4f] = ["Cortex-M0", "Cortex-M4F"].map(|name| CHIPS.iter().find(|chip| chip.name == name).unwrap());
    if let Some(tool) = m0.missing() {
        skipped(
            "microcontrollers",
            &format!("the size of controllers, for want of {tool}"),
        );
        return;
    }
    let folder = folder("sizes");
    fs::write(folder.0.join("used.c"), USED).unwrap();
    let built = |chip: &Chip, options: &[&str]| {
        let (compiler, processor) = (chip.compile[0], &chip.compile[1..]);
        let small = [
            "-ffunction-sections",
            "-fdata-sections",
            "-Wl,--gc-sections",
            "-o",
            "program",
        ];
        let compiled = compile(
            &folder.0,
            compiler,
            &[processor, CORTEX, &small, options].concat(),
            &["used.c".to_owned()],
        );
        assert!(
            compiled.status.success(),
            "{}",
            String::from_utf8_lossy(&compiled.stderr)
        );
    };
    let bytes = || {
        let output = Command::new("arm-none-eabi-size")
            .arg("program")
            .current_dir(&folder.0)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line = text.lines().nth(1).unwrap().split_whitespace();
        line.take(2).map(|number| number.parse::<u32>().unwrap()).sum::<u32>()
    };
    built(m4f, &[]);
    let without = bytes();
    let network = WorldSpec {
        robot: epucks(Model::Rm11, Reference::DEFAULT, 4),
        controller: world::Controller::Perceptron,
        ..modules::spec(world::Controller::Perceptron, 4)
    };
    let machine = world::Controller::StateMachine(Modules::DEFAULT);
    for (what, world, most_bytes, most_instructions) in [
        ("a perceptron of 8 inputs", lives::world(100, |_| {}), 1_500, 20_000),
        ("the network of RM1.1", World::new(network).unwrap(), 4_000, 20_000),
        (
            "a machine of four states",
            World::new(modules::spec(machine, 4)).unwrap(),
            6_144,
            20_000,
        ),
    ] {
        let mut genes = modules::genome(&world, 1);
        if let Some(states) = world
            .gene_layout()
            .controller()
            .iter()
            .position(|gene| gene.name == "states")
        {
            genes[states] = 4.5;
        }
        let controller = Controller::new(&world, &genes, 0).unwrap();
        let recorded = controller
            .record(&mut Cpu::new(Some(1)).unwrap(), Key::rollout(3, 0, 0, 0))
            .unwrap();
        fs::write(folder.0.join("taken.c"), c(&controller, "taken", &[], &recorded[..1])).unwrap();
        let keys = if controller.draws() { "-DKEYS=,1u,2u" } else { "-DKEYS=" };
        built(m4f, &["-DNAME", keys]);
        let bytes = bytes() - without;
        built(m0, &["-DNAME", "-DCOUNTED", keys]);
        let mut command = Command::new(m0.run[0]);
        let command =
            command
                .args(&m0.run[1..])
                .args(QEMU)
                .args(["-icount", "shift=0", "-semihosting", "-kernel", "program"]);
        let hundreds = command.current_dir(&folder.0).status().unwrap().code().unwrap();
        println!("{what}: {bytes} bytes on a Cortex-M4F, {hundreds}00 instructions a cycle on a Cortex-M0");
        assert!(bytes < most_bytes, "{what}: {bytes} bytes");
        assert!(
            (10..most_instructions / 100).contains(&hundreds),
            "{what}: {hundreds}00 instructions"
        );
    }
}
