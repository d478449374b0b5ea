//! The surrogate of a real Khepera: statistics of its sensors, each difference, and the same bits everywhere.

use std::sync::Arc;

use oneiro::arena::{Arena, Field, Wall};
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Difference, Differences, Surrogate};
use oneiro::world::{Controller, Noise, Start, World, WorldSpec};

fn open(surrogate: Surrogate, start: [f32; 3]) -> World {
    let wall = Wall {
        from: [0.0, -2000.0],
        to: [0.0, 2000.0],
        class: "wall".into(),
    };
    let field = Field {
        x: -1000.0,
        y: -500.0,
        width: 1000.0,
        height: 1000.0,
    };
    let arena = Arena {
        name: "a wall".into(),
        field,
        walls: vec![wall],
        ..Arena::default()
    };
    let [x, y, heading] = start;
    World::new(WorldSpec {
        surrogate: Some(Arc::new(surrogate)),
        arena,
        start: Start::At { x, y, heading },
        cycles: 1,
        ..WorldSpec::miglino1995()
    })
    .unwrap()
}

/// A sensor's reading of a wall, of 1023, head-on or at an angle.
fn reading(surrogate: &Surrogate, sensor: usize, gap: f32, off_axis: f64) -> f32 {
    let bearing = surrogate.individual.sensors[sensor].bearing + off_axis;
    // The wall is in the direction 0; bearings are clockwise from the heading.
    let heading = (bearing / 360.0).rem_euclid(1.0) as f32;
    let world = open(surrogate.clone(), [-27.5 - gap, 0.0, heading]);
    let genes = [0.0; 18];
    let rollout = Rollout {
        world: 0,
        genes: &genes,
        key: Key::of_words([1, 2]),
    };
    let batch = Batch::new(&[world], &[rollout], Some(TraceRequest { every: 1 })).unwrap();
    evaluated(&mut scalar(), &batch)[0].activations(0)[sensor] * 1023.0
}

fn quiet(seed: u64) -> Surrogate {
    Surrogate::drawn(seed, Differences::only(1.0, Difference::Geometry))
}

#[test]
fn sensors_have_the_moments_they_were_drawn_with() {
    for seed in [1, 2] {
        let surrogate = quiet(seed);
        for (index, sensor) in surrogate.individual.sensors.iter().enumerate() {
            let half = reading(&surrogate, index, sensor.half as f32, 0.0);
            assert!(
                (half - 511.5).abs() < 3.0,
                "sensor {index}: {half} at {} mm",
                sensor.half
            );
            let twentieth = reading(&surrogate, index, sensor.twentieth as f32, 0.0);
            assert!(
                (twentieth - 51.0).abs() < 3.0,
                "sensor {index}: {twentieth} at {} mm",
                sensor.twentieth
            );
            for side in [-0.5, 0.5] {
                let edge = reading(&surrogate, index, 15.0, side * sensor.width);
                assert!(
                    (edge - 511.5).abs() < 25.0,
                    "sensor {index}: {edge} at {} degrees",
                    side * sensor.width
                );
            }
        }
    }
}

fn genes(rollout: u32, count: usize) -> Vec<f32> {
    (0..count as u32)
        .map(|gene| (pcg4d([rollout, gene, 0, 0])[0] >> 8) as f32 / 1_677_721.6 - 5.0)
        .collect()
}

fn world(differences: Differences, controller: Controller, cycles: u32) -> World {
    World::new(WorldSpec {
        surrogate: Some(Arc::new(Surrogate::drawn(1, differences))),
        controller,
        cycles,
        ..WorldSpec::miglino1995()
    })
    .unwrap()
}

fn batch(world: World, lives: u32) -> Batch {
    let genomes: Vec<_> = (0..lives).map(|life| genes(life, world.genes())).collect();
    let rollouts: Vec<_> = genomes
        .iter()
        .zip(0..)
        .map(|(genes, life)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(1, 0, life, 0),
        })
        .collect();
    Batch::new(&[world], &rollouts, Some(TraceRequest { every: 1 })).unwrap()
}

fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> Vec<Trace> {
    evaluator.evaluate(batch, &Control::new()).unwrap().traces
}

fn scalar() -> Cpu {
    Cpu::new(Some(1)).unwrap().with_variant("scalarx1").unwrap()
}

/// Each difference alone changes what is read or where robots end up; without differences, a robot's surroundings don't
/// matter.
#[test]
fn each_difference_shows() {
    let lives_in = |world| evaluated(&mut scalar(), &batch(world, 200));
    let lives = |differences| lives_in(world(differences, Controller::Perceptron, 40));
    let elsewhere = |severity| {
        let mut spec = world(Differences::all(severity), Controller::Perceptron, 40)
            .spec()
            .clone();
        spec.surrogate = Some(Arc::new(Surrogate {
            surroundings: Surrogate::drawn(2, Differences::all(severity)).surroundings,
            ..Surrogate::drawn(1, Differences::all(severity))
        }));
        lives_in(World::new(spec).unwrap())
    };
    let none = lives(Differences::all(0.0));
    assert!(none == elsewhere(0.0));
    assert!(lives(Differences::all(1.0)) != elsewhere(1.0));
    for difference in Difference::ALL {
        let changed = lives(Differences::only(1.0, difference));
        let lives = changed.iter().zip(&none).filter(|(one, other)| one != other).count();
        assert!(lives > 20, "{}: {lives} of 200 lives", difference.name());
        let all_but = Differences::without(1.0, difference);
        assert_eq!(all_but.strength(difference), 0.0);
    }
}

#[test]
fn individuals_and_surroundings_are_of_their_seed() {
    let [one, same, other] = [1, 1, 2].map(|seed| Surrogate::drawn(seed, Differences::all(1.0)));
    assert_eq!(one, same);
    assert_ne!(one.individual, other.individual);
    assert_ne!(one.surroundings, other.surroundings);
}

#[test]
fn a_surrogate_takes_no_noise_of_the_simulator() {
    let wrong = |change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(1, Differences::all(1.0)))),
            ..WorldSpec::miglino1995()
        };
        change(&mut spec);
        World::new(spec).unwrap_err().field
    };
    assert_eq!(wrong(&|spec| spec.noise = Noise::SENSOR), "noise");
    let severe = Surrogate::drawn(1, Differences::all(2.5));
    assert_eq!(
        wrong(&|spec| spec.surrogate = Some(Arc::new(severe.clone()))),
        "surrogate.severity"
    );
    let mut blind = Surrogate::drawn(1, Differences::all(1.0));
    blind.individual.sensors[3].half = f64::NAN;
    assert_eq!(
        wrong(&|spec| spec.surrogate = Some(Arc::new(blind.clone()))),
        "surrogate.sensors[3].half"
    );
}
