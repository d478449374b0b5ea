//! Controllers in other languages: in C all kinds have the simulator's bits in thousands of cycles, by every compiler and with every
//! optimisation; what would change the bits doesn't compile, has no effect, or is found by the file itself. Files in the other languages
//! find nothing that differs in their first cycles, and in `tests/long.sh` in all.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::{env, fs};

use oneiro::automode::Modules;
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Genomes};
use oneiro::export::{Also, Controller, Form, TARGETS, arduino};
use oneiro::foraging::Forager;
use oneiro::random::Key;
use oneiro::world::{self, Noise, Robot, World, WorldSpec};

use crate::exported::{Folder, QUIET, Subject, checked, compared_here, compile, is_there};
use crate::skips::skipped;
use crate::{described, lives, modules, network};

/// Uses all that a controller may ask for: values, random numbers, the trial, genes and elements at places that vary, and memory of
/// all types, under names that C has taken.
const CUSTOM: &str = "
struct ControllerValues {
    gain: f32, // 2, 0 to 10: factor of what it remembers
}
const CONTROLLER_GENES: u32 = 20u;
struct ControllerState {
    double: f32,
    cycle: vec2<f32>,
    count: u32,
    side: vec3<i32>,
}
fn stored_twice(x: f32) -> f32 {
    return 0.5f * (x + x);
}
fn controller_begin(episode: Episode) -> ControllerState {
    return ControllerState(gene(episode, 3u), vec2<f32>(0.25f, 0.0f), trial(episode), vec3<i32>(1, -2, 3));
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let values = controller_values(episode);
    let drawn = random(episode, STREAM_CONTROLLER, step, 1u);
    var last = array<f32, 4>(drawn.x, drawn.y, drawn.z, drawn.w);
    last[before.count % 4u] = reading(readings, before.count % INPUTS);
    var sum = before.double / (2.0 + abs(before.cycle.x));
    for (var at = 0u; at < 20u; at++) {
        if (last[at % 4u] < 0.1) {
            continue;
        }
        sum += gene(episode, (at * 7u + before.count) % 20u) * last[(at + step) % 4u];
        if (sum > 30.0) {
            break;
        }
    }
    let turned = sin(sum) * cos(values.gain) + sqrt(abs(sum)) - floor(0.3 * sum);
    let side = before.side.x * -3 + (before.side.y >> 1u) + i32(clamp(sum, -5.0, 5.0));
    let outputs = vec2<f32>(logistic(stored_twice(turned)), logistic(values.gain - turned + f32(side % 8)));
    return Command(outputs, ControllerState(
        clamp(sum, -100.0, 100.0), vec2<f32>(turned, outputs.x), before.count * 1664525u + 1013904223u,
        vec3<i32>(clamp(side, -1000, 1000), before.side.x, -before.side.z),
    ));
}
";

/// A robot of a swarm that knows its number.
const NUMBERED: &str = "
const CONTROLLER_GENES: u32 = 2u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let own = f32(robot_number(episode)) * gene(episode, 0u);
    return Command(vec2<f32>(logistic(own), logistic(reading(readings, 0u) * gene(episode, 1u))), before);
}
";

fn custom(text: &str) -> OwnParts {
    let part = Part::new(Kind::Controller, "own.wgsl", text).unwrap();
    OwnParts::from([OwnPart::new(Arc::new(part), &[]).unwrap()])
}

fn forager() -> WorldSpec {
    WorldSpec {
        controller: world::Controller::Recurrent,
        cycles: 300,
        ..WorldSpec::foraging(Forager::ODOWD2014)
    }
}

/// Worlds with all kinds of controllers, and the robots whose controllers are taken.
fn worlds() -> Vec<(String, World, u32)> {
    let sampled = |controller: world::Controller| {
        lives::world(400, |spec| {
            spec.controller = controller.clone();
            spec.noise = Noise::SENSOR;
        })
    };
    let of = |spec: WorldSpec| World::new(spec).unwrap();
    let described = |controller| {
        of(WorldSpec {
            robot: Robot {
                build: Build::Differential(Differential {
                    acceleration: Some(500.0),
                    ..described::robot()
                }),
                ..Robot::khepera()
            },
            arena: described::arena(),
            controller,
            cycles: 400,
            ..WorldSpec::miglino1995()
        })
    };
    let own = lives::world(400, |spec| {
        spec.controller = world::Controller::Own;
        spec.own = custom(CUSTOM);
    });
    let teams = |controller| {
        let mut spec = modules::spec(controller, 6);
        if let Build::Differential(robot) = &mut spec.robot.build {
            robot.genomes = Genomes::Heterogeneous;
        }
        of(spec)
    };
    let numbered = {
        let mut spec = modules::spec(world::Controller::Own, 5);
        spec.own = custom(NUMBERED);
        of(spec)
    };
    // Searches at random, and seeks the light.
    let behaviours = WorldSpec::foraging(Forager::ODOWD2014);
    let machine = world::Controller::StateMachine(Modules::DEFAULT);
    let tree = world::Controller::BehaviourTree(Modules::DEFAULT);
    let mut worlds = vec![
        ("perceptron".to_owned(), sampled(world::Controller::Perceptron), 0),
        ("hidden".to_owned(), sampled(world::Controller::Hidden { units: 6 }), 0),
        ("recurrent".to_owned(), sampled(world::Controller::Recurrent), 0),
        ("described".to_owned(), described(world::Controller::Recurrent), 0),
        ("own".to_owned(), own, 0),
        ("forager".to_owned(), of(forager()), 0),
        ("behaviours".to_owned(), of(behaviours), 0),
        ("numbered".to_owned(), numbered, 4),
        ("machine".to_owned(), of(modules::spec(machine.clone(), 4)), 2),
        ("team_machine".to_owned(), teams(machine), 5),
        ("tree".to_owned(), of(modules::spec(tree.clone(), 4)), 3),
        ("team_tree".to_owned(), teams(tree), 1),
    ];
    for (number, network) in network::networks().into_iter().enumerate() {
        let network = world::Controller::Network(network);
        worlds.push((format!("network_{number}"), sampled(network), 0));
    }
    worlds
}

/// Controllers with random genes, and the cycles of three episodes of each.
fn subjects() -> Vec<Subject> {
    subjects_with(0)
}

/// The same of at least so many cycles.
pub(crate) fn subjects_with(least: usize) -> Vec<Subject> {
    let subject = |(name, world, robot): (String, World, u32)| {
        let genome = modules::genome(&world, name.len() as u32);
        Subject::new(name, &world, &genome, robot, least)
    };
    worlds().into_iter().map(subject).collect()
}

fn write(folder: &Path, subject: &Subject, cycles: usize) {
    subject.write(folder, &subject.cycles[..cycles]);
}

#[test]
fn all_kinds_of_controllers_have_the_simulators_bits_in_c() {
    let least = if env::var_os("ONEIRO_LONG").is_some() {
        10_000
    } else {
        0
    };
    compared_here("kinds", &subjects_with(least));
}

/// A language: the target, what runs it, and a driver's text with `NAMES`, each with `check` around it, whose lines are what checks return.
struct Driven {
    target: &'static str,
    /// Programs of which the first is there, and the options before the driver's name.
    programs: &'static [&'static [&'static str]],
    driver: &'static str,
    /// Its beginning, and what it does, for each controller.
    each: [fn(&str) -> String; 2],
}

const PYTHON: [fn(&str) -> String; 2] = [
    |name| format!("import {name}\n"),
    |name| format!("print({name}.check())\n"),
];

const DRIVEN: [Driven; 6] = [
    Driven {
        target: "cpp",
        programs: &[
            &["g++", "-std=c++11", "-O2", "-o", "driver"],
            &["clang++", "-std=c++11", "-O1", "-o", "driver"],
        ],
        driver: "driver.cpp",
        // Twice, as by two headers.
        each: [
            |name| format!("#include \"{name}.hpp\"\n#include \"{name}.hpp\"\n"),
            |name| format!("std::printf(\"%d\\n\", {name}::check());\n"),
        ],
    },
    Driven {
        target: "rust",
        programs: &[&["rustc", "--edition=2021", "-Dwarnings", "-o", "driver"]],
        driver: "driver.rs",
        each: [
            |name| format!("mod {name};\n"),
            |name| format!("println!(\"{{}}\", {name}::check());\n"),
        ],
    },
    Driven {
        target: "javascript",
        programs: &[&["node"]],
        driver: "driver.mjs",
        each: [
            |name| format!("import * as {name} from \"./{name}.mjs\";\n"),
            |name| format!("console.log({name}.check());\n"),
        ],
    },
    Driven {
        target: "python",
        programs: &[&["python3", "-B"]],
        driver: "driver.py",
        each: PYTHON,
    },
    Driven {
        target: "lua",
        programs: &[&["lua5.1"]],
        driver: "driver.lua",
        each: [
            |_| String::new(),
            |name| format!("print(require(\"{name}\").check())\n"),
        ],
    },
    Driven {
        target: "lua",
        programs: &[&["lua5.4"]],
        driver: "driver.lua",
        each: [
            |_| String::new(),
            |name| format!("print(string.format(\"%d\", require(\"{name}\").check()))\n"),
        ],
    },
];

impl Driven {
    /// What the checks of controllers return.
    fn checked(&self, folder: &Path, program: &[&str], subjects: &[&Subject], cycles: usize) -> Vec<u32> {
        let target = TARGETS.iter().find(|target| target.name == self.target).unwrap();
        let Form::File(extensions, print) = target.form else {
            panic!("{} is a folder", self.target);
        };
        let [mut begin, mut body] = [const { String::new() }; 2];
        for Subject {
            name,
            controller,
            cycles: all,
        } in subjects
        {
            let origin = ["a test /* of */ comments".to_owned()];
            let text = print(controller, name, &origin, &all[..cycles.min(all.len())]);
            fs::write(folder.join(name).with_extension(extensions[0]), text).unwrap();
            begin += &self.each[0](name);
            body += &self.each[1](name);
        }
        let text = match self.target {
            "cpp" => format!("#include <cstdio>\n{begin}int main() {{\n{body}}}\n"),
            "rust" => format!("#![no_std]\nextern crate std;\nuse std::println;\n{begin}fn main() {{\n{body}}}\n"),
            _ => begin + &body,
        };
        fs::write(folder.join(self.driver), text).unwrap();
        let [program, options @ ..] = program else {
            unreachable!()
        };
        let quiet: &[&str] = if self.target == "cpp" { &QUIET } else { &[] };
        let options = [quiet, options].concat();
        let mut output = compile(folder, program, &options, &[self.driver.to_owned()]);
        let messages = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{program} {options:?}: {messages}");
        if options.contains(&"-o") {
            output = Command::new(folder.join("driver")).output().unwrap();
        }
        let lines = String::from_utf8(output.stdout).unwrap();
        lines.lines().map(|line| line.parse().unwrap()).collect()
    }
}

/// All kinds, in hundreds of cycles of each. `tests/micropython.sh` installs it.
#[test]
#[ignore = "needs MicroPython from npm, which tests/long.sh installs"]
fn python_has_the_simulators_bits_in_micropython() {
    let driven = Driven {
        target: "python",
        programs: &[],
        driver: "driver.py",
        each: PYTHON,
    };
    let folder = Folder::new("micropython");
    let subjects = subjects();
    for subject in &subjects {
        let differing = driven.checked(&folder.0, &["micropython"], &[subject], 500);
        assert_eq!(differing, [0], "{}", subject.name);
    }
    let mut changed = network_subject();
    changed.cycles[11].outputs[1] = changed.cycles[11].outputs[1].next_up();
    assert_eq!(driven.checked(&folder.0, &["micropython"], &[&changed], 16), [12]);
    println!("{} controllers", subjects.len());
}

#[test]
fn other_languages_have_the_simulators_bits() {
    let subjects = subjects();
    let is_long = env::var_os("ONEIRO_LONG").is_some();
    let cycles = if is_long { usize::MAX } else { 60 };
    let is_usual = |subject: &&Subject| ["network_4", "machine", "own"].contains(&&*subject.name);
    let all: Vec<&Subject> = subjects.iter().filter(|subject| is_long || is_usual(subject)).collect();
    for driven in &DRIVEN {
        let folder = Folder::new(driven.target);
        let is_there = |program: &&&[&str]| Command::new(program[0]).arg("-v").output().is_ok();
        let Some(program) = driven.programs.iter().find(is_there) else {
            skipped(
                "languages",
                &format!("controllers in {} by {:?}", driven.target, driven.programs),
            );
            continue;
        };
        let differing = driven.checked(&folder.0, program, &all, cycles);
        let wrong: Vec<_> = all.iter().zip(&differing).filter(|(_, number)| **number != 0).collect();
        let wrong: Vec<_> = wrong.iter().map(|(subject, number)| (&subject.name, number)).collect();
        assert!(
            wrong.is_empty() && differing.len() == all.len(),
            "{program:?}: {wrong:?}"
        );
        // An output's last bit, and what is remembered.
        let mut changed = network_subject();
        changed.cycles[11].outputs[1] = changed.cycles[11].outputs[1].next_up();
        assert_eq!(driven.checked(&folder.0, program, &[&changed], 16), [12], "{program:?}");
        changed.cycles[3].after = changed.cycles[0].before.clone();
        assert_eq!(driven.checked(&folder.0, program, &[&changed], 16), [4], "{program:?}");
        println!("{program:?}: {} controllers", all.len());
    }
}

/// The core that Debian has for an Uno.
const ARDUINO: &str = "/usr/share/arduino/hardware/arduino/avr";

/// An example's program says on an emulated Uno that its controller has the bits, and drives.
#[test]
fn an_arduino_sketch_has_the_simulators_bits() {
    let is_there = |tool| Command::new(tool).arg("--version").output().is_ok();
    if !Path::new(ARDUINO).is_dir() || !is_there("avr-gcc") || !is_there("simavr") {
        skipped(
            "microcontrollers",
            "an Arduino library, for want of arduino-core-avr, avr-gcc or simavr",
        );
        return;
    }
    let subjects = subjects();
    let folder = Folder::new("arduino");
    let core = format!("{ARDUINO}/cores/arduino");
    let mut sources: Vec<String> = fs::read_dir(&core)
        .unwrap()
        .map(|entry| entry.unwrap().path().display().to_string())
        .filter(|path| [".c", ".cpp", ".S"].iter().any(|end| path.ends_with(end)))
        // Debian's compiler is older than it.
        .filter(|path| !path.ends_with("WString.cpp"))
        .collect();
    sources.push("sketch.cpp".to_owned());
    // It draws random numbers.
    let name = "own";
    let subject = subjects.iter().find(|subject| subject.name == name).unwrap();
    for (path, text) in arduino(&subject.controller, name, &[], &subject.cycles[..8]) {
        let path = folder.0.join(name).join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    // The development environment does the same to a sketch.
    let sketch = fs::read_to_string(folder.0.join(format!("{name}/examples/{name}/{name}.ino"))).unwrap();
    fs::write(folder.0.join("sketch.cpp"), format!("#include <Arduino.h>\n{sketch}")).unwrap();
    let options = [
        "-std=gnu++11",
        "-mmcu=atmega328p",
        "-DF_CPU=16000000L",
        "-DARDUINO=10819",
        "-DARDUINO_AVR_UNO",
        "-DARDUINO_ARCH_AVR",
        "-Os",
        "-w",
        "-fpermissive",
        "-fno-exceptions",
        "-fno-threadsafe-statics",
        "-ffunction-sections",
        "-fdata-sections",
        "-Wl,--gc-sections",
        "-o",
        "program",
        "-I",
        &core,
        "-I",
        &format!("{ARDUINO}/variants/standard"),
        "-I",
        &format!("{name}/src"),
    ];
    let compiled = compile(&folder.0, "avr-gcc", &options, &sources);
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{name}: {messages}");
    // It runs for good.
    let mut command = Command::new("timeout");
    let output = command
        .args(["3", "simavr", "-m", "atmega328p", "-f", "16000000", "program"])
        .current_dir(&folder.0)
        .output()
        .unwrap();
    let shown = [output.stdout, output.stderr].concat();
    let shown = String::from_utf8_lossy(&shown).into_owned();
    let lines: Vec<_> = shown
        .lines()
        .filter_map(|line| line.rsplit_once("[32m")?.1.split("..").next())
        .collect();
    assert!(lines.first() == Some(&"0") && lines.len() > 2, "{name}: {shown}");
    assert!(
        lines[1].split(' ').all(|speed| speed.parse::<f32>().is_ok()),
        "{name}: {shown}"
    );
}

/// A controller whose bits any fused product changes.
fn network_subject() -> Subject {
    let all = subjects();
    all.into_iter().find(|subject| subject.name == "network_2").unwrap()
}

/// Cppcheck finds nothing, and no rule of MISRA C 2012 but these, which are advisory: precedence without parentheses, `goto`, several
/// returns or breaks, unions, and names that are used or could be declared in one place.
#[test]
fn checkers_of_embedded_code_are_quiet() {
    const ADVISORY: [&str; 9] = ["2.3", "2.4", "8.7", "8.9", "12.1", "15.1", "15.4", "15.5", "19.2"];
    if !is_there("cppcheck") {
        return;
    }
    let is_long = env::var_os("ONEIRO_LONG").is_some();
    let folder = Folder::new("checkers");
    let subjects = subjects();
    let is_usual = |subject: &&Subject| is_long || ["described", "own"].contains(&&*subject.name);
    let mut files = Vec::new();
    for subject in subjects.iter().filter(is_usual) {
        // One with its world, which has thousands of lines.
        let mut controller = subject.controller.clone();
        if subject.name == "described" {
            let also = Also {
                sensors: true,
                task: true,
            };
            controller = controller.with_world(also, Key::of_words([1, 2])).unwrap();
        }
        let subject = Subject {
            name: subject.name.clone(),
            cycles: subject.cycles.clone(),
            controller,
        };
        write(&folder.0, &subject, 4);
        files.push(format!("{}.c", subject.name));
    }
    // What a compiler would define.
    let defined = [
        "__FLT_EVAL_METHOD__=0",
        "FLT_RADIX=2",
        "FLT_MANT_DIG=24",
        "FLT_MAX_EXP=128",
    ];
    let defined = defined.map(|what| format!("-D{what}"));
    // Each by itself: names of different programs may be the same.
    let found = |file: &String| {
        let output = Command::new("cppcheck")
            .args(["--std=c99", "--quiet", "--template={file}:{line}: {id}"])
            .args(["--enable=warning,performance,portability", "--addon=misra"])
            // Newer versions say so of long functions: a word on their search, and no finding.
            .arg("--suppress=normalCheckLevelMaxBranches")
            .args(&defined)
            .arg(file)
            .current_dir(&folder.0)
            .output()
            .unwrap();
        let lines = String::from_utf8(output.stderr).unwrap();
        let lines = lines.lines().filter(|line| line.contains(".c:"));
        let mut lines: Vec<_> = lines.map(str::to_owned).collect();
        assert!(lines.len() > 4, "{lines:?}");
        lines.retain(|line| {
            let rule = line.rsplit_once("misra-c2012-").map_or("", |(_, rule)| rule);
            !ADVISORY.contains(&rule)
        });
        lines
    };
    let wrong: Vec<_> = files.iter().flat_map(found).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    // A required rule, that a composite expression isn't cast to another type, and a fault.
    let text = fs::read_to_string(folder.0.join(files.last().unwrap())).unwrap();
    let cast = "\nint32_t cast_of(uint32_t x);\nint32_t cast_of(uint32_t x)\n{\n    return (int32_t)(x + 1u);\n}\n";
    let divided = "\nint divided(void);\nint divided(void)\n{\n    return 1 / 0;\n}\n";
    fs::write(folder.0.join("cast.c"), text + cast + divided).unwrap();
    let wrong = found(&"cast.c".to_owned());
    assert!(wrong.iter().any(|line| line.ends_with("10.8")), "{wrong:?}");
    assert!(wrong.iter().any(|line| line.ends_with("zerodiv")), "{wrong:?}");
    assert!(wrong.len() == 2, "{wrong:?}");
}

#[test]
fn other_arithmetic_does_not_compile() {
    let folder = Folder::new("flags");
    let subject = network_subject();
    write(&folder.0, &subject, 1);
    let file = [format!("{}.c", subject.name)];
    let fast: [(&str, &[&str]); 7] = [
        ("gcc", &["-ffast-math"]),
        ("gcc", &["-Ofast"]),
        ("gcc", &["-funsafe-math-optimizations"]),
        ("gcc", &["-ffinite-math-only"]),
        ("clang", &["-ffast-math"]),
        ("clang", &["-Ofast"]),
        ("clang", &["-ffinite-math-only"]),
    ];
    let refused = |compiler: &str, options: &[&str], reason: &str| {
        let compiled = compile(&folder.0, compiler, &[options, &["-c"]].concat(), &file);
        let messages = String::from_utf8_lossy(&compiled.stderr);
        assert!(
            !compiled.status.success() && messages.contains(reason),
            "{compiler} {options:?}: {messages}"
        );
    };
    for (compiler, options) in fast {
        if is_there(compiler) {
            refused(compiler, options, "fast-math changes the bits");
        }
    }
    if cfg!(target_arch = "x86_64") && is_there("gcc") {
        refused("gcc", &["-mfpmath=387"], "FLT_EVAL_METHOD 0");
    }
}

#[test]
fn fused_products_are_prevented_or_found() {
    #[cfg(target_arch = "x86_64")]
    if !std::arch::is_x86_feature_detected!("fma") {
        skipped("fma", "controllers as C with fused products");
        return;
    }
    let options: &[&str] = if cfg!(target_arch = "x86_64") {
        &["-O2", "-ffp-contract=fast", "-mfma"]
    } else {
        &["-O2", "-ffp-contract=fast"]
    };
    let folder = Folder::new("fused");
    let subject = network_subject();
    let names = [subject.name.as_str()];
    write(&folder.0, &subject, 16);
    if is_there("gcc") {
        assert_eq!(checked(&folder.0, "gcc", options, &names), [0]);
        // Without the file's own words to the compiler, they are found.
        let path = folder.0.join(format!("{}.c", subject.name));
        let text = fs::read_to_string(&path).unwrap();
        let pragma = "#pragma GCC optimize (\"fp-contract=off\")";
        assert!(text.contains(pragma));
        fs::write(&path, text.replace(pragma, "")).unwrap();
        assert_ne!(checked(&folder.0, "gcc", options, &names), [0]);
        fs::write(&path, text).unwrap();
    }
    if is_there("clang") {
        // Its option goes before the file's words.
        assert_ne!(checked(&folder.0, "clang", options, &names), [0]);
        let by_default: Vec<_> = options
            .iter()
            .copied()
            .filter(|option| !option.contains("contract"))
            .collect();
        assert_eq!(checked(&folder.0, "clang", &by_default, &names), [0]);
    }
}

/// A cycle, an output, and what is remembered: one bit of each is found, in its cycle.
#[test]
fn a_file_finds_what_differs() {
    if !is_there("gcc") {
        return;
    }
    let folder = Folder::new("differs");
    let mut subject = network_subject();
    let names = [subject.name.clone()];
    let names = names.each_ref().map(String::as_str);
    let found = |subject: &Subject| {
        write(&folder.0, subject, 16);
        checked(&folder.0, "gcc", &["-O1"], &names)
    };
    assert_eq!(found(&subject), [0]);
    let output = &mut subject.cycles[11].outputs[1];
    *output = output.next_up();
    assert_eq!(found(&subject), [12]);
    subject.cycles[3].after = subject.cycles[0].before.clone();
    assert_eq!(found(&subject), [4]);
}

#[test]
fn what_needs_its_simulator_is_refused() {
    let world = lives::world(100, |_| {});
    let refused = |world: &World, genes: &[f32], robot| Controller::new(world, genes, robot).unwrap_err().to_string();
    assert_eq!(refused(&world, &[0.0; 17], 0), "genes: are 17; allowed: 18");
    let mut genes = [0.0; 18];
    genes[4] = f32::NAN;
    assert_eq!(
        refused(&world, &genes, 0),
        "genes[4]: is NaN; allowed: up to 1000000 either way"
    );
    assert_eq!(refused(&world, &[0.0; 18], 1), "robot: is 1; allowed: 0 to 0");
    let others = {
        let mut spec = modules::spec(world::Controller::Own, 3);
        spec.own = custom(
            "const CONTROLLER_GENES: u32 = 1u;
            fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
                return Command(vec2<f32>(0.001f * robot_pose(episode, 1u).x, 0.5f), before);
            }",
        );
        World::new(spec).unwrap()
    };
    let problem = refused(&others, &[0.0], 0);
    assert!(
        problem.starts_with("controller: asks for what only its simulator has (`state`)"),
        "{problem}"
    );
    let seer = lives::world(100, |spec| {
        spec.controller = world::Controller::Own;
        spec.own = custom(
            "const CONTROLLER_GENES: u32 = 1u;
            fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
                return Command(vec2<f32>(reading(readings, 0u), 0.5f), before);
            }",
        );
    });
    let controller = Controller::new(&seer, &[0.0], 0).unwrap();
    let mut state = controller.reset([0; 2], 0);
    assert_eq!(controller.step(&mut state, &[0.25; 8]).unwrap(), [0.25, 0.5]);
    let problem = |readings: &[f32]| controller.step(&mut state.clone(), readings).unwrap_err().to_string();
    assert_eq!(problem(&[0.0; 7]), "readings: are 7; allowed: 8");
    let infinite = [0.0, f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(
        problem(&infinite),
        "readings[1]: is inf; allowed: up to 1000000 either way"
    );
    assert_eq!(
        controller.wheels([0.5, 1.5]).unwrap_err().to_string(),
        "outputs: has 1.5; allowed: 0 to 1"
    );
}

/// The wheels of robots without noise do what the simulator's do.
#[test]
fn wheels_are_the_simulators() {
    let described = |speeds| {
        World::new(WorldSpec {
            robot: Robot {
                build: Build::Differential(Differential {
                    speeds,
                    ..described::robot()
                }),
                ..Robot::khepera()
            },
            arena: described::arena(),
            cycles: 300,
            ..WorldSpec::miglino1995()
        })
        .unwrap()
    };
    let mut swarm = modules::spec(world::Controller::Recurrent, 3);
    if let Build::Differential(robot) = &mut swarm.robot.build {
        robot.wheel_noise = None;
        robot.wheel_noise_law = None;
    }
    let swarm = World::new(swarm).unwrap();
    let worlds = [lives::world(300, |_| {}), described(0), described(7), swarm];
    for (number, world) in worlds.iter().enumerate() {
        let genome = lives::genes(number, world.genes());
        let controller = Controller::new(world, &genome, 0).unwrap();
        let batch = modules::batch(world, &[genome], 1);
        let outcome = modules::evaluated(&mut Cpu::new(Some(1)).unwrap(), &batch);
        let mut seen = BTreeSet::new();
        for record in &outcome.traces[0] {
            let speeds = controller
                .wheels([record.left, record.right])
                .unwrap()
                .map(f32::to_bits);
            assert_eq!(
                speeds,
                [record.speed_left, record.speed_right].map(f32::to_bits),
                "world {number}"
            );
            seen.insert(speeds);
        }
        assert!(seen.len() > 3, "world {number}: {seen:?}");
    }
    // A sampled robot's speeds are those of its motors' states.
    let sampled = Controller::new(&worlds[0], &lives::genes(0, 18), 0).unwrap();
    assert_eq!(
        [sampled.wheels([0.0, 1.0]).unwrap(), sampled.wheels([1.0, 0.0]).unwrap()],
        [[-1.0, 1.0], [1.0, -1.0]]
    );
}
