//! Controllers as C on other processors, which are emulated: they have the simulator's bits, and GCC would fuse products without the file's
//! words. `tests/long.sh` tries all kinds of controllers, in 10,000 cycles each where the emulator is fast enough.

use std::fs;
use std::process::Command;

use oneiro::automode::Modules;
use oneiro::cpu::Cpu;
use oneiro::export::{Controller, c};
use oneiro::random::Key;
use oneiro::reference::{Model, Reference};
use oneiro::world::{self, World, WorldSpec};

use crate::epucks::epucks;
use crate::export::subjects_with;
use crate::exported::chips::{CHIPS, CORTEX, Chip, QEMU, chips, compared_on_all, folder};
use crate::exported::compile;
use crate::skips::skipped;
use crate::{lives, modules};

#[test]
fn microcontrollers_have_the_simulators_bits() {
    let subjects = subjects_with(0);
    let folder = folder("chips");
    let (mut fused, chips) = (0, chips(false));
    for chip in &chips {
        for name in ["perceptron", "network_4", "machine"] {
            let subject = subjects.iter().find(|subject| subject.name == name).unwrap();
            let count = chip.cycles(&subject.cycles[0]).min(300);
            subject.write(&folder.0, &subject.cycles[..count]);
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

/// Of each kind of controller.
#[test]
#[ignore = "emulates nine processors for ten minutes: tests/long.sh runs it"]
fn all_chips_have_the_simulators_bits_in_ten_thousand_cycles() {
    const CYCLES: usize = 10_000;
    compared_on_all("kinds", &subjects_with(CYCLES), CYCLES);
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
