//! Speed of arenas by the number of robots in a world and of worlds in a batch: `cargo bench --bench worlds`. It shows how many
//! worlds fill the lanes of a processor, and the threads of a graphics adapter if there is one.

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
        std::hint::black_box(evaluator.evaluate(batch, &Control::new()).expect("an evaluation"));
        start.elapsed()
    };
    let fastest = (0..TURNS).map(turn).min().unwrap_or(Duration::MAX);
    batch.steps() as f64 / fastest.as_secs_f64()
}
