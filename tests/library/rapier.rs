//! The swarm's arena compared with a [twin] whose bodies rapier moves: ten robots collect as much food in either. The
//! arena's bits are pinned (`tests/library/goldens.rs`), so `tests/long.sh` alone runs this: it is due again when they change.
//!
//! Controllers, lights, the margin and the number of worlds were fixed before any comparison: the arena's own worlds of
//! ten minutes differ by 0.11, 0.08 and 0.11 of their mean for the first three cases, and by 0.46 and 0.50 for the
//! others. With 2 (0.11 / 0.0277)^2 = 32 worlds, the interval of a ratio that is 1 lies within the margin in nine of
//! ten comparisons; the others took 640.
//!
//! Results, as ratios of the arena's rate to the twin's, plus and minus half of the interval:
//!
//! | with food, without, light | worlds | first twin | worlds | with the arena's forms |
//! |---|---|---|---|---|
//! | random, random, nowhere | 64 | 1.00 +- 0.04 | 40 | 0.97 +- 0.04 |
//! | seek, random, over the nest | 64 | 1.00 +- 0.03 | 40 | 1.03 +- 0.04 |
//! | flee, random, opposite | 64 | **1.06 +- 0.05** | 40 | 0.98 +- 0.04 |
//! | seek, flee, over the nest | 128 | 0.96 +- 0.12 | 640 | 0.97 +- 0.05 |
//! | flee, seek, opposite | 128 | **0.72 +- 0.12** | 640 | 0.99 +- 0.05 |
//!
//! The last two were compared before a bug in the arena's food was fixed. Since then the first of them is undecided
//! with 640 worlds, 1.05 +- 0.05, and the other has not been compared; the test now takes 2,560.
//!
//! The twin as first written, from the documentation alone, differs from the arena in two cases. Contacts aren't the
//! cause: with the arena's way of pushing bodies apart in place of rapier's, the last ratio was 0.71, since robots that
//! see each other hardly ever touch. The causes are the three laws listed in [`Forms`], whose forms the documentation
//! leaves open. The gain's form alone left 0.73, the sensors' alone 0.72, the darkest of several shadows in place of
//! all of them 0.76; these three together 0.87 +- 0.05, with 512 worlds; and with the form of a single shadow as well
//! 0.98 +- 0.08, with 256. These forms were looked up in the kernel after the first comparison, so for these laws the
//! twin is no independent witness.

mod twin;

use oneiro::cpu::Cpu;
use oneiro::evaluator::Control;
use oneiro::foraging::{Foraging, Light};
use oneiro::random::Key;
use oneiro::swarm::{Arena, Lamp, Line, Order, Simulated, Swarm, World};
use twin::{Forms, Twins};

const MINUTES: u32 = 10;
const ROBOTS: u32 = 10;
/// Accepted ratios of the arena's rate to the twin's, for the whole 95 % interval.
const MARGIN: (f64, f64) = (0.9, 1.1);
/// Controller and light.
type Case = ([f32; 2], Light);
/// Cases with little variation between worlds.
const EVEN: [Case; 3] = [
    ([0.5, 0.5], Light::Nowhere),
    ([0.99, 0.5], Light::OverNest),
    ([0.0, 0.5], Light::OppositeNest),
];
const EVEN_WORLDS: usize = 40;
/// Enough to see a difference of a quarter.
const FEW_WORLDS: usize = 10;
/// Cases in which robots crowd far from the food, more in some worlds than in others.
const UNEVEN: [Case; 2] = [([0.99, 0.0], Light::OverNest), ([0.0, 0.99], Light::OppositeNest)];
const UNEVEN_WORLDS: usize = 2560;

/// Food collected per robot-minute in each world.
fn rates(arena: &mut dyn Arena, genes: [f32; 2], worlds: usize) -> Vec<f64> {
    let orders = vec![vec![Order::always(genes); ROBOTS as usize]; worlds];
    let mut brought = vec![0; worlds];
    let count = |lines: &Vec<Line>| -> u32 {
        lines
            .iter()
            .flat_map(|line| &line.robots)
            .map(|seen| seen.brought)
            .sum()
    };
    for minute in 1..=MINUTES {
        let lived = arena.live(600 * minute, &orders, 10).unwrap();
        for (brought, lines) in brought.iter_mut().zip(&lived) {
            *brought += count(lines);
        }
    }
    let rate = |brought| f64::from(brought) / f64::from(MINUTES * ROBOTS);
    brought.into_iter().map(rate).collect()
}

/// Rates of the arena, each of whose worlds has different robots, as in the twin.
fn arena_rates(swarm: Swarm, (genes, light): Case, worlds: usize) -> Vec<f64> {
    /// Most worlds that fit into one trace.
    const AT_ONCE: usize = 640;
    let mut cpu = Cpu::new(None).unwrap();
    let control = Control::new();
    let all: Vec<u64> = (0..worlds as u64).collect();
    let some = |numbers: &[u64]| {
        let swarms: Vec<Swarm> = numbers
            .iter()
            .map(|&individuals| Swarm { individuals, ..swarm })
            .collect();
        let life = |(swarm, &number): (usize, &u64)| World {
            swarm,
            lamp: Lamp::fixed(light),
            key: Key::rollout(5, 0, number, 0),
        };
        let lives: Vec<World> = numbers.iter().enumerate().map(life).collect();
        let mut arena = Simulated::new(&mut cpu, &control, &swarms, &lives).unwrap();
        rates(&mut arena, genes, numbers.len())
    };
    all.chunks(AT_ONCE).flat_map(some).collect()
}

fn twin_rates(swarm: Swarm, (genes, light): Case, forms: Forms, worlds: usize) -> Vec<f64> {
    let mut arena = Twins::new(swarm, Lamp::fixed(light), forms, worlds as u64);
    rates(&mut arena, genes, worlds)
}

/// A mean, and its squared standard error as a share of it.
fn mean_and_error(sample: &[f64]) -> (f64, f64) {
    let count = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / count;
    let variance = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, variance / count / (mean * mean))
}

/// Ends of the 95 % interval of the ratio of two means.
fn ratio(name: &str, arena: &[f64], twin: &[f64]) -> (f64, f64) {
    let [(here, error), (there, other)] = [mean_and_error(arena), mean_and_error(twin)];
    let spread = (1.96 * (error + other).sqrt()).exp();
    let ratio = here / there;
    println!(
        "{name}: arena {here:.4}, twin {there:.4}, ratio {ratio:.3}, {:.3} to {:.3}",
        ratio / spread,
        ratio * spread
    );
    (ratio / spread, ratio * spread)
}

fn is_equivalent(interval: (f64, f64)) -> bool {
    interval.0 > MARGIN.0 && interval.1 < MARGIN.1
}

fn agree(cases: &[Case], forms: Forms, worlds: usize) {
    let swarm = Swarm::odowd2014(ROBOTS);
    let mut others = Vec::new();
    for &case in cases {
        let name = format!("{case:?}, {forms:?}");
        let interval = ratio(
            &name,
            &arena_rates(swarm, case, worlds),
            &twin_rates(swarm, case, forms, worlds),
        );
        if !is_equivalent(interval) {
            others.push(format!("{name}: {interval:?}"));
        }
    }
    assert!(others.is_empty(), "{others:?}");
}

#[test]
fn bodies_that_rapier_moves_bring_as_much_food() {
    agree(&EVEN, Forms::Arena, EVEN_WORLDS);
}

/// In these cases the forms that the documentation leaves open don't matter.
#[test]
fn a_twin_by_the_documentation_alone_brings_as_much_food() {
    agree(&EVEN[..2], Forms::First, EVEN_WORLDS);
}

#[test]
#[ignore = "takes two processors a quarter of an hour: crowds differ so much that a margin of 10 % needs thousands of worlds"]
fn bodies_that_rapier_moves_bring_as_much_food_in_crowds() {
    agree(&UNEVEN, Forms::Arena, UNEVEN_WORLDS);
}

/// Robots at three quarters of their speed differ from the arena's, so the tests above can fail.
#[test]
fn slower_robots_are_seen() {
    let swarm = Swarm::odowd2014(ROBOTS);
    let slow = Swarm {
        forager: Foraging {
            cruise: 60.0,
            ..swarm.forager
        },
        ..swarm
    };
    let case = EVEN[1];
    let interval = ratio(
        "slower",
        &arena_rates(swarm, case, FEW_WORLDS),
        &twin_rates(slow, case, Forms::Arena, FEW_WORLDS),
    );
    assert!(!is_equivalent(interval) && interval.0 > 1.0, "{interval:?}");
}
