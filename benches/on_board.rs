//! An on-board generation of the 2014 study: ten controllers live a minute each in the on-board simulator, on one thread.
//! `cargo bench --bench on_board` has its time by lane code. With a lane code and a number of generations, as in
//! `cargo bench --bench on_board -- scalarx1 5`, it only lets them live: for `tests/arm-instructions.sh`, which counts instructions.

use std::env;
use std::hint::black_box;
use std::time::Instant;

use oneiro::batch::Worlds;
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};

#[expect(dead_code, reason = "other benchmarks use the rest")]
mod subjects;
use subjects::{batch, genomes};

/// Controllers that a robot has.
const CONTROLLERS: usize = 10;
/// Generations by which time is taken.
const GENERATIONS: usize = 200;

fn main() {
    let arguments: Vec<String> = env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    if let [lane_code, generations] = &arguments[..] {
        return live(lane_code, generations.parse().expect("a number of generations"));
    }
    println!("ms for {CONTROLLERS} controllers and 600 cycles, the mean of {GENERATIONS} generations\n");
    for lane_code in Cpu::variants().into_iter().filter(|name| !name.starts_with("checked")) {
        live(lane_code, 1);
        let start = Instant::now();
        live(lane_code, GENERATIONS);
        println!(
            "{lane_code:16}{:.3}",
            start.elapsed().as_secs_f64() * 1e3 / GENERATIONS as f64
        );
    }
}

/// Lets generations live, each in another of the three scenarios.
fn live(lane_code: &str, generations: usize) {
    let mut cpu = Cpu::new(Some(1)).and_then(|cpu| cpu.with_variant(lane_code));
    let cpu = cpu.as_mut().expect("it is available");
    let hundredth = |word: u32| (word % 100) as f32 / 100.0;
    let genomes = genomes(CONTROLLERS, 2, hundredth);
    let worlds = [Light::OverNest, Light::Nowhere, Light::OppositeNest].map(Foraging::odowd2014);
    let batches = worlds.map(|world| batch(&Worlds::new(&[world]).expect("a valid world"), &genomes));
    for generation in 0..generations {
        let outcome = cpu.evaluate(&batches[generation % batches.len()], &Control::new());
        black_box(outcome.expect("an evaluation"));
    }
}
