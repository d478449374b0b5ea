//! Properties of the surrogate and its simulator that the study relies on.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use oneiro::arena::Arena;
use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Robot, World, WorldSpec};
use oneiro_base::console::{Console, Output};
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::reality::Object;
use oneiro_lab::reality::sampling::sample_unkept;
use oneiro_lab::reality::site::Site;
use oneiro_robots::address::Address;

use super::settings::{Asked, Settings};
use super::simulated_robot;
use super::study::Study;
use crate::file::{Edition, MIGLINO1995, StudyFile};

pub(super) fn evaluations() -> Engine {
    Engine::new(Box::new(Cpu::new(None).unwrap()), Arc::new(AtomicBool::new(false)))
}

mod wired;

/// A small study of the first edition, which has the arms.
pub(super) fn settings(arm: &str, severity: f32) -> Settings {
    let asked = Asked {
        seed: 1,
        runs: Some(2),
        robot: Address::Surrogate(3),
        severity: Some(severity),
        full: false,
        tables: Vec::new(),
    };
    let file = StudyFile::open(&MIGLINO1995, None).unwrap();
    Settings::new(&file.in_edition(Edition::First).unwrap(), arm, asked).unwrap()
}

/// A study of the built-in robot.
pub(super) fn study<'a>(settings: &'a Settings, evaluations: &'a Engine) -> Study<'a> {
    let console = Console::new(Output::default());
    Study::new(settings, Robot::khepera(), settings.site(), evaluations, console).unwrap()
}

/// The simulator made from a surrogate's samples, and the surrogate's world.
fn worlds(seed: u64, differences: Differences, arena: Arena) -> [World; 2] {
    let evaluations = evaluations();
    let surrogate = Surrogate::drawn(seed, differences);
    let settings = settings("main", 0.0);
    let spec = settings.world();
    let mut robot = Site::surrogate(seed, surrogate.clone())
        .sampled(&evaluations, &spec)
        .unwrap();
    let objects: Vec<Object> = Object::NAMES.into_iter().filter_map(Object::named).collect();
    let samples = sample_unkept(&mut *robot, &objects).unwrap();
    let simulator = WorldSpec {
        robot: simulated_robot(&settings, samples.sensors, &samples.motors),
        arena,
        ..spec
    };
    let real = WorldSpec {
        surrogate: Some(Arc::new(surrogate)),
        ..simulator.clone()
    };
    [World::new(simulator).unwrap(), World::new(real).unwrap()]
}

/// Genes of random controllers that drive forwards if nothing is near, so that they get around.
fn genes(episode: u32) -> Vec<f32> {
    (0..18)
        .map(|gene| {
            let share = (pcg4d([episode, gene, 7, 7])[0] >> 8) as f32 / 8_388_608.0 - 1.0;
            if gene % 9 == 8 { 1.0 + share } else { 4.0 * share }
        })
        .collect()
}

/// Without differences a surrogate reads the same as its simulator, with the same bits in the first cycle, and its
/// episodes are as good.
#[test]
fn without_severity_reality_is_the_simulator() {
    for arena in [Arena::miglino1995(), Arena::miglino1995_block()] {
        without_severity_reality_is_the_simulator_in(&arena);
    }
}

fn without_severity_reality_is_the_simulator_in(arena: &Arena) {
    const LIVES: u32 = 4000;
    let genomes: Vec<_> = (0..LIVES).map(genes).collect();
    let [simulated, real] = worlds(5, Differences::all(0.0), arena.clone()).map(|world| {
        let rollouts: Vec<_> = genomes
            .iter()
            .zip(0..)
            .map(|(genes, episode)| Rollout {
                world: 0,
                genes,
                key: Key::rollout(3, 0, episode, 0),
            })
            .collect();
        let batch = Batch::new(&[world], &rollouts, Some(TraceRequest { every: 50 })).unwrap();
        Cpu::new(None).unwrap().evaluate(&batch, &Control::new()).unwrap()
    });
    let mut same = 0;
    let mut seen = 0;
    for (a, b) in simulated.traces.iter().zip(&real.traces) {
        let first = [a.activations(0), b.activations(0)];
        same += usize::from(first[0] == first[1]);
        seen += usize::from(first[0].iter().any(|reading| *reading > 0.0));
    }
    assert!(seen > 2000, "{seen} episodes start where something is seen");
    assert_eq!(same, LIVES as usize);
    let moments = |fitness: &[f32]| {
        let count = fitness.len() as f64;
        let mean = fitness.iter().map(|&f| f64::from(f)).sum::<f64>() / count;
        let square = fitness
            .iter()
            .map(|&f| (f64::from(f) - mean) * (f64::from(f) - mean))
            .sum::<f64>();
        (mean, square / (count - 1.0))
    };
    let ((a, va), (b, vb)) = (moments(&simulated.fitness), moments(&real.fitness));
    let d = (a - b) / (0.5 * (va + vb)).sqrt();
    // Rounding makes paths part after many cycles. Two samples of 4,000 from one population differ by 0.045 at p = .05,
    // and these share their starts.
    assert!(d.abs() < 0.02, "{}, d {d}: {a} and {b}", arena.name);
}

/// With all differences, reality differs from the simulator: the test above can fail.
#[test]
fn with_severity_reality_is_another() {
    let [simulated, real] = worlds(5, Differences::all(1.0), Arena::miglino1995());
    let genome = genes(1);
    let episodes = |world: World| {
        let rollouts: Vec<_> = (0..500)
            .map(|episode| Rollout {
                world: 0,
                genes: &genome,
                key: Key::rollout(3, 0, episode, 0),
            })
            .collect();
        let batch = Batch::new(&[world], &rollouts, None).unwrap();
        Cpu::new(None)
            .unwrap()
            .evaluate(&batch, &Control::new())
            .unwrap()
            .fitness
    };
    assert_ne!(episodes(simulated), episodes(real));
}

/// The first assumptions of the list are those of the worlds: bodies slide, and a cycle that ends in a collision earns nothing.
#[test]
fn collisions_are_as_the_assumptions_say() {
    let file = StudyFile::open(&MIGLINO1995, None).unwrap();
    let listed = |edition| {
        let asked = Asked {
            seed: 1,
            runs: Some(2),
            robot: Address::Surrogate(3),
            severity: None,
            full: false,
            tables: Vec::new(),
        };
        let file = StudyFile::open(&MIGLINO1995, None)
            .unwrap()
            .in_edition(edition)
            .unwrap();
        Settings::new(&file, "main", asked).unwrap()
    };
    assert_eq!(file.edition(), Edition::Second);
    let settings = listed(Edition::Second);
    let rows: Vec<(String, String)> = settings
        .assumptions()
        .into_iter()
        .take(4)
        .map(|row| (row.name, row.value))
        .collect();
    let expected = [
        (
            "robot.collision",
            "slide: the robot slides along what it would touch, and turns",
        ),
        ("collision.fitness", "0: a cycle that ends in a collision earns nothing"),
        ("task.difference", "root: 1 - sqrt(DV)"),
        (
            "task.speed",
            "unsigned: (|left| + |right|) / 2: driving backwards counts like driving forwards",
        ),
    ];
    for ((name, value), (key, words)) in rows.iter().zip(expected) {
        assert_eq!((&**name, &**value), (key, words));
    }
    // Straight ahead into a wall, at a slant.
    let genes: Vec<f32> = (0..18).map(|gene| if gene % 9 == 8 { 5.0 } else { 0.0 }).collect();
    let slides = [Edition::First, Edition::Second].map(|edition| {
        let start = oneiro::world::Start::At {
            x: 60.0,
            y: 200.0,
            heading: 0.4,
        };
        let world = World::new(WorldSpec {
            start,
            ..listed(edition).world()
        })
        .unwrap();
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(3, 0, 0, 0),
        };
        let batch = Batch::new(&[world], &[rollout], Some(TraceRequest { every: 1 })).unwrap();
        let trace = &Cpu::new(None)
            .unwrap()
            .evaluate(&batch, &Control::new())
            .unwrap()
            .traces[0];
        let (mut collided, mut moved) = (0, 0.0_f32);
        for cycle in 1..trace.len() - 1 {
            let (before, now, next) = (trace[cycle - 1], trace[cycle], trace[cycle + 1]);
            if now.collided > 0.0 {
                assert_eq!(now.fitness, before.fitness, "cycle {cycle}");
                collided += 1;
                moved += (next.x - now.x).hypot(next.y - now.y);
            }
        }
        assert!(collided > 20, "{collided} collisions");
        moved
    });
    assert!(slides[0] == 0.0 && slides[1] > 50.0, "{slides:?}");
}
