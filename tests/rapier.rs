//! The swarm's arena against a twin with other physics: rapier moves its bodies.

#[path = "rapier/twin.rs"]
mod twin;

use oneiro::cpu::Cpu;
use oneiro::evaluator::Control;
use oneiro::foraging::Light;
use oneiro::random::Key;
use oneiro::swarm::{Arena, Differences, Lamp, Line, Order, Simulated, Swarm, World};
use twin::{Bodies, Twins};

const CYCLES: u32 = 6_000;
/// Controllers and lights, fixed before any comparison.
const CASES: [([f32; 2], Light); 5] = [
    ([0.99, 0.0], Light::OverNest),
    ([0.5, 0.5], Light::Nowhere),
    ([0.0, 0.99], Light::OppositeNest),
    ([0.99, 0.5], Light::OverNest),
    ([0.0, 0.5], Light::OppositeNest),
];

/// Food brought per robot-minute, of each world.
fn rates(worlds: &[Vec<Line>]) -> Vec<f64> {
    let rate = |lines: &Vec<Line>| {
        let robots = lines[0].robots.len();
        let brought: u32 = lines
            .iter()
            .flat_map(|line| &line.robots)
            .map(|robot| robot.brought)
            .sum();
        f64::from(brought) / (robots as f64 * f64::from(CYCLES) / 600.0)
    };
    worlds.iter().map(rate).collect()
}

fn lived(arena: &mut dyn Arena, robots: u32, worlds: usize, genes: [f32; 2]) -> Vec<f64> {
    let orders = vec![vec![Order::always(genes); robots as usize]; worlds];
    rates(&arena.live(CYCLES, &orders, 10).unwrap())
}

/// The kernel's worlds, each with other robots.
fn kernel(swarm: Swarm, genes: [f32; 2], light: Light, worlds: usize) -> Vec<f64> {
    let swarms: Vec<Swarm> = (0..worlds as u64)
        .map(|individuals| Swarm { individuals, ..swarm })
        .collect();
    let lives: Vec<World> = (0..worlds)
        .map(|index| World {
            swarm: index,
            lamp: Lamp::fixed(light),
            key: Key::rollout(5, 0, index as u64, 0),
        })
        .collect();
    let mut cpu = Cpu::new(None).unwrap();
    let control = Control::new();
    let mut arena = Simulated::new(&mut cpu, &control, &swarms, &lives).unwrap();
    lived(&mut arena, swarm.robots, worlds, genes)
}

fn twin(swarm: Swarm, genes: [f32; 2], light: Light, bodies: Bodies, worlds: usize) -> Vec<f64> {
    let mut arena = Twins::new(swarm, Lamp::fixed(light), bodies, worlds as u64);
    lived(&mut arena, swarm.robots, worlds, genes)
}

fn mean_and_variance(sample: &[f64]) -> (f64, f64) {
    let count = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / count;
    let variance = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, variance)
}

#[test]
fn spread() {
    for (genes, light) in CASES {
        let start = std::time::Instant::now();
        let k = kernel(Swarm::odowd2014(10), genes, light, 64);
        let (m, v) = mean_and_variance(&k);
        println!("{genes:?} {light:?} {m} cv {} {:?}", v.sqrt() / m, start.elapsed());
    }
    let start = std::time::Instant::now();
    twin(
        Swarm {
            robots: 10,
            ..Swarm::odowd2014(10)
        },
        CASES[0].0,
        CASES[0].1,
        Bodies::Solid,
        2,
    );
    println!("twin 2 worlds {:?}", start.elapsed());
}
