//! Speed of arenas by the number of robots in a world and of worlds in a batch: `cargo bench --bench worlds`. It shows how many
//! worlds fill the lanes of a processor, and the threads of a graphics adapter if there is one. With `-- driven` it shows how
//! fast a world of ten robots is that are driven from outside.

use std::hint::black_box;
use std::time::{Duration, Instant};

use oneiro::batch::{Batch, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::swarm::{Lamp, Order, Swarm};

#[expect(dead_code, reason = "other benchmarks use the rest")]
mod subjects;
use subjects::{batch, genomes};

const ROBOTS: [u32; 4] = [1, 10, 40, 100];
const WORLDS: [usize; 6] = [1, 4, 16, 32, 64, 256];
/// Robot-steps of a turn, for which lives are as long as they must be, within these numbers of cycles.
const STEPS: usize = 400_000;
const CYCLES: [usize; 2] = [50, 1200];
/// Turns, of which the fastest counts: others were interrupted.
const TURNS: usize = 7;

fn main() {
    #[cfg(feature = "compose")]
    if std::env::args().any(|word| word == "driven") {
        return driven();
    }
    println!(
        "million robot-steps/s, the fastest of {TURNS} turns\n\n{:32}{:>9}{}",
        "",
        "worlds",
        columns(WORLDS)
    );
    for threads in [1, 2] {
        let mut cpu = Cpu::new(Some(threads)).expect("it is available");
        lines(&format!("{threads} thread, {}", cpu.device().detail), &mut cpu, &ROBOTS);
    }
    #[cfg(feature = "gpu")]
    if let Ok(mut gpu) = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best) {
        // Drivers in software refuse more robots: their loops are too long.
        lines(&gpu.device().name, &mut gpu, &ROBOTS[..3]);
    }
}

/// Cycles per second of a world of ten robots that are driven from outside, alone and with the behaviours of the study as
/// their minds.
#[cfg(feature = "compose")]
fn driven() {
    use oneiro::acting::Acting;
    use oneiro::random::Key;
    use oneiro::swarm::{Command, Drive, Driven, robot_key};

    const TIMED: u32 = 5_000;
    let swarm = Swarm::odowd2014(10);
    let key = Key::rollout(1, 0, 0, 0);
    let mut cpu = Cpu::new(Some(1)).expect("it is available");
    let begin = |cpu: &mut Cpu| Driven::new(cpu, &swarm, Lamp::fixed(Light::OverNest), key).expect("a valid world");
    let timed = |name: &str, cycle: &mut dyn FnMut()| {
        let turn = |_| {
            let start = Instant::now();
            (0..TIMED / TURNS as u32).for_each(|_| cycle());
            start.elapsed()
        };
        let fastest = (0..TURNS).map(turn).min().unwrap_or(Duration::MAX);
        let rate = f64::from(TIMED / TURNS as u32) / fastest.as_secs_f64();
        println!("{name:32}{rate:9.0} cycles/s");
    };

    let start = Instant::now();
    let mut world = begin(&mut cpu);
    println!(
        "{:32}{:9.3} s",
        "the first world is there after",
        start.elapsed().as_secs_f64()
    );
    let command = |drive| Command {
        drive: Some(drive),
        begins: false,
    };
    let ahead = command(Drive {
        forward: 8.0,
        turn: 0.01,
    });
    timed("ten robots, driven", &mut || {
        black_box(world.cycle(&mut cpu, &[ahead; 10]).expect("a cycle"));
    });

    let mut world = begin(&mut cpu);
    let acting = Acting::new(&swarm.forager).expect("a valid robot");
    let mut minds: Vec<_> = (0..10).map(|robot| Acting::begin(robot_key(key, robot))).collect();
    let mut carries = [false; 10];
    timed("ten robots and their minds", &mut || {
        let each = minds.iter_mut().zip(world.readings()).zip(carries);
        let commands: Vec<_> = each
            .map(|((mind, readings), carries)| {
                let deed = acting.cycle(mind, &mut cpu, [0.99, 0.5], readings, carries);
                command(deed.expect("a deed").drive())
            })
            .collect();
        let line = world.cycle(&mut cpu, &commands).expect("a cycle");
        carries = std::array::from_fn(|robot| line.robots[robot].carries);
    });
}

fn columns(cells: impl IntoIterator<Item: std::fmt::Display>) -> String {
    let cells = cells.into_iter().map(|cell| format!("{cell:>9}"));
    cells.collect::<Vec<_>>().concat()
}

/// A line for each number of robots.
fn lines(device: &str, evaluator: &mut dyn Evaluator, robots: &[u32]) {
    for &robots in robots {
        let rates = WORLDS.map(|worlds| format!("{:.2}", rate(evaluator, &swarms(robots, worlds)) / 1e6));
        println!("{device:32.32}{:>9}{}", format!("{robots}"), columns(rates));
    }
}

/// Worlds of robots with random genes.
fn swarms(robots: u32, worlds: usize) -> Batch {
    let cycles = (STEPS / (robots as usize * worlds)).clamp(CYCLES[0], CYCLES[1]);
    let swarm = Swarm {
        forager: Foraging {
            cycles: cycles as u32,
            ..Swarm::odowd2014(robots).forager
        },
        ..Swarm::odowd2014(robots)
    };
    let hundredth = |word: u32| (word % 100) as f32 / 100.0;
    let inputs = |genes: &Vec<f32>| {
        let orders = genes.as_chunks::<2>().0.iter().map(|genes| Order::always(*genes));
        swarm.inputs(&Lamp::fixed(Light::OverNest), &orders.collect::<Vec<_>>())
    };
    let inputs: Vec<Vec<f32>> = genomes(worlds, 2 * robots, hundredth).iter().map(inputs).collect();
    batch(&Worlds::new(&[swarm]).expect("valid worlds"), &inputs)
}

/// Robot-steps per second in the fastest of several turns.
fn rate(evaluator: &mut dyn Evaluator, batch: &Batch) -> f64 {
    let turn = |_| {
        let start = Instant::now();
        black_box(evaluator.evaluate(batch, &Control::new()).expect("an evaluation"));
        start.elapsed()
    };
    let fastest = (0..TURNS).map(turn).min().unwrap_or(Duration::MAX);
    batch.steps() as f64 / fastest.as_secs_f64()
}
