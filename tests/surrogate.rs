//! The surrogate of a real Khepera: its sensors' moments, its differences one by one, and the same bits everywhere.

use std::sync::Arc;

use oneiro::arena::{Arena, Field, Wall};
use oneiro::batch::{Batch, Record, Rollout, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Difference, Differences, Surrogate};
use oneiro::world::{Start, World, WorldSpec};

/// Genes that hold both wheels at one of the 20 states, whatever the sensors read: -10 to -1, 1 to 10.
fn held(left: f32, right: f32) -> Vec<f32> {
    let bias = |output: f32| (output / (1.0 - output)).ln();
    let mut genes = vec![0.0; 18];
    (genes[8], genes[17]) = (bias(left), bias(right));
    genes
}

fn lives(worlds: &[World], rollouts: &[Rollout<'_>], every: u32) -> (Vec<f32>, Vec<Vec<Record>>) {
    let batch = Batch::new(worlds, rollouts, Some(TraceRequest { every })).unwrap();
    let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    (outcome.fitness, outcome.traces)
}

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
        obstacles: Vec::new(),
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

/// What one sensor reads of a wall, of 1023, head-on or at an angle.
fn reading(surrogate: &Surrogate, sensor: usize, gap: f32, off_axis: f64) -> f32 {
    let bearing = surrogate.individual.sensors[sensor].bearing + off_axis;
    // The wall is in the direction 0; bearings are clockwise from the heading.
    let heading = (bearing / 360.0).rem_euclid(1.0) as f32;
    let world = open(surrogate.clone(), [-27.5 - gap, 0.0, heading]);
    let genes = held(0.55, 0.55);
    let rollout = Rollout {
        world: 0,
        genes: &genes,
        key: Key([1, 2]),
    };
    let (_, traces) = lives(&[world], &[rollout], 1);
    let r = traces[0][0];
    let all = [
        r.sensor_0, r.sensor_1, r.sensor_2, r.sensor_3, r.sensor_4, r.sensor_5, r.sensor_6, r.sensor_7,
    ];
    all[sensor] * 1023.0
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

fn genes(rollout: u32) -> Vec<f32> {
    (0..18)
        .map(|gene| (pcg4d([rollout, gene, 0, 0])[0] >> 8) as f32 / 1_677_721.6 - 5.0)
        .collect()
}

#[test]
fn speed() {
    let n = 2000;
    let genomes: Vec<_> = (0..n).map(genes).collect();
    for differences in [Differences::all(0.0), Differences::all(1.0), Differences::all(0.7)] {
        let world = World::new(WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(1, differences))),
            ..WorldSpec::miglino1995()
        })
        .unwrap();
        let rollouts: Vec<_> = genomes
            .iter()
            .enumerate()
            .map(|(index, genes)| Rollout {
                world: 0,
                genes,
                key: Key::rollout(1, 0, index as u64, 0),
            })
            .collect();
        let batch = Batch::new(&[world], &rollouts, None).unwrap();
        for variant in Cpu::variants() {
            if variant.starts_with("checked") || variant.starts_with("scalar") {
                continue;
            }
            let mut cpu = Cpu::new(Some(1)).unwrap().with_variant(variant).unwrap();
            let start = std::time::Instant::now();
            let outcome = cpu.evaluate(&batch, &Control::new()).unwrap();
            let mean = outcome.fitness.iter().sum::<f32>() / n as f32;
            println!(
                "{} {variant}: {:.2} M steps/s, mean {mean}",
                differences.severity,
                batch.steps() as f64 / start.elapsed().as_secs_f64() / 1e6
            );
        }
    }
}
