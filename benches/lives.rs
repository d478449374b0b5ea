//! Speeds of the lane codes in the episodes that `oneiro device bench` doesn't time: `cargo bench --bench lives`. Surrogates with
//! severities other than 0 and 1 mix both models of the sensors, and so take the time of both.

use std::sync::Arc;

use oneiro::batch::Worlds;
use oneiro::foraging::{Foraging, Light};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{Lamp, Order, Swarm};
use oneiro::world::{World, WorldSpec};

mod subjects;
use subjects::{Subject, batch, genomes, weight};

/// Rollouts per turn.
const ROLLOUTS: usize = 2000;
/// Worlds of ten robots per turn.
const SWARMS: usize = 100;
/// Turns of each lane code.
const TURNS: usize = 5;

fn main() {
    println!("{:24}  lane code             M steps/s", "life");
    for severity in [0.0, 1.0, 1.75] {
        let world = World::new(WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(1, Differences::all(severity)))),
            ..WorldSpec::miglino1995()
        })
        .expect("a valid world");
        let genomes = genomes(ROLLOUTS, world.genes() as u32, weight);
        let worlds = Worlds::new(&[world]).expect("valid worlds");
        time(&format!("surrogate, severity {severity}"), &worlds, &genomes);
    }
    let foragers = Worlds::new(&[Foraging::odowd2014(Light::OverNest)]).expect("valid worlds");
    let hundredth = |word: u32| (word % 100) as f32 / 100.0;
    time("forager", &foragers, &genomes(ROLLOUTS, 2, hundredth));

    // A robot-step is one robot in one cycle.
    let lamp = Lamp::fixed(Light::OverNest);
    for (robots, worlds) in [(10, SWARMS), (100, SWARMS / 5)] {
        let swarm = Swarm {
            forager: Foraging {
                cycles: 1200,
                ..Swarm::odowd2014(robots).forager
            },
            ..Swarm::odowd2014(robots)
        };
        let inputs: Vec<Vec<f32>> = genomes(worlds, 2 * robots, hundredth)
            .iter()
            .map(|genes| {
                let orders: Vec<Order> = genes
                    .as_chunks::<2>()
                    .0
                    .iter()
                    .map(|genes| Order::always(*genes))
                    .collect();
                swarm.inputs(&lamp, &orders)
            })
            .collect();
        let swarms = Worlds::new(&[swarm]).expect("valid worlds");
        time(&format!("swarm of {robots}"), &swarms, &inputs);
    }
}

/// Times lives on each lane code in turn, several times, and prints the medians.
fn time(life: &str, worlds: &Worlds, genomes: &[Vec<f32>]) {
    let batch = batch(worlds, genomes);
    let mut subjects = Subject::all(&[1, 2]);
    for _ in 0..TURNS {
        for subject in &mut subjects {
            subject.take_turn(&batch);
        }
    }
    for (subject, rate) in subjects.into_iter().map(Subject::result) {
        println!("{life:24}  {subject:20} {:10.2}", rate / 1e6);
    }
}
