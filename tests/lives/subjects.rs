//! For each kernel, worlds that together reach every branch of it, and rollouts in them.

use std::sync::Arc;

use oneiro::acting::Behaviours;
use oneiro::arena::Arena;
use oneiro::batch::{Batch, GREATEST_GENE, LEAST_GENE, Rollout, TraceRequest, Worlds};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{self, Differences, Surrogate};
use oneiro::swarm::{self, Lamp, Order, Swarm};
use oneiro::tables::{MotorStates, MotorTable};
use oneiro::world::{Activation, Controller, Difference, Noise, Speed, Start, Task, World, WorldSpec};

use super::choices::{beside_a_block, collisions, specs, task};

/// A world and the rollouts in it.
pub(crate) struct Subject {
    pub(crate) name: String,
    pub(crate) worlds: Worlds,
    /// Genes of each rollout.
    pub(crate) genomes: Vec<Vec<f32>>,
}

impl Subject {
    /// Whole lives, with a record every `every` cycles.
    pub(crate) fn batch(&self, every: u32) -> Batch {
        let rollouts: Vec<_> = (0..)
            .zip(&self.genomes)
            .map(|(index, genes)| Rollout {
                world: 0,
                genes,
                key: Key::rollout(7, 0, index, 0),
            })
            .collect();
        let trace = TraceRequest { every };
        self.worlds.batch(&rollouts, Some(trace)).expect("a valid batch")
    }
}

/// Worlds of a kernel of the catalogue, by its name; empty if it simulates nothing.
pub(crate) fn of_kernel(name: &str) -> Vec<Subject> {
    let controllers: &[Controller] = match name.rsplit('_').next() {
        Some("perceptron") => &[Controller::Perceptron],
        Some("hidden") => &[1, 3, 32].map(|units| Controller::Hidden { units }),
        Some("recurrent") => &[Controller::Recurrent],
        _ => &[],
    };
    match name.split('_').next() {
        Some("life") => lives(controllers),
        Some("surrogate") => surrogates(controllers),
        Some("forager") if name == "forager_many" => foragers_with_many_items(),
        Some("forager") => foragers(),
        Some("swarm") => swarms(),
        Some("acting") => behaviours(),
        _ => Vec::new(),
    }
}

/// For each kind of kernel, a world with all noises whose lives are long, by the kernel's name.
pub(crate) fn long() -> Vec<(&'static str, Subject)> {
    let spec = |surrogate| WorldSpec {
        cycles: 100_000,
        surrogate,
        ..WorldSpec::miglino1995()
    };
    let simulated = WorldSpec {
        noise: Noise {
            sensor: (-0.2, 0.2),
            motor: 0.1,
            ..Noise::CONSERVATIVE
        },
        ..spec(None)
    };
    let surrogate = spec(Some(Arc::new(Surrogate::drawn(1, Differences::all(1.75)))));
    let of = |spec: WorldSpec| subjects(vec![("long".into(), spec)], &[Controller::Recurrent], 6).remove(0);
    let forager = Foraging {
        cycles: 100_000,
        ..Foraging::odowd2014(Light::OverNest)
    };
    let swarm = Swarm::odowd2014(10);
    let alone = Subject {
        name: "long".into(),
        worlds: Worlds::new(&[forager]).expect("a valid world"),
        genomes: (0..9).map(|rollout| thirds(rollout).into()).collect(),
    };
    let together = Subject {
        name: "long".into(),
        worlds: Worlds::new(&[swarm]).expect("a valid world"),
        genomes: (0..3)
            .map(|rollout| orders(&swarm, rollout, swarm.forager.cycles))
            .collect(),
    };
    vec![
        ("life_recurrent", of(simulated)),
        ("surrogate_recurrent", of(surrogate)),
        ("forager", alone),
        ("swarm", together),
    ]
}

/// Distinct genes from -`size` to `size`, the same in all worlds, so that differences come from the worlds.
fn genes(rollout: u32, count: usize, size: f32) -> Vec<f32> {
    let gene = |gene| {
        let [word, ..] = pcg4d([rollout, gene, 0, 0x676f_6c64]);
        ((word >> 8) as f32 / 8_388_608.0 - 1.0) * size
    };
    (0..count as u32).map(gene).collect()
}

/// Worlds with controllers that take turns in them; the first world has each controller.
fn subjects(specs: Vec<(String, WorldSpec)>, controllers: &[Controller], rollouts: u32) -> Vec<Subject> {
    let again = specs[0].clone();
    let all = controllers.iter().skip(1).map(|_| again.clone()).chain(specs);
    all.zip(controllers.iter().cycle())
        .map(|((name, mut spec), controller)| {
            spec.controller = controller.clone();
            let world = World::new(spec).unwrap_or_else(|error| panic!("{name}: {error}"));
            let name = match controller {
                Controller::Hidden { units } => format!("{name}, {units} hidden"),
                _ => name,
            };
            // Small and large genes; the last rollout's are the smallest and largest allowed.
            let count = world.genes();
            let sizes = [5.0, 1.0, 20.0].into_iter().cycle();
            let genomes = (1..rollouts)
                .zip(sizes)
                .map(|(rollout, size)| genes(rollout, count, size));
            Subject {
                genomes: genomes.chain([extreme(count)]).collect(),
                worlds: Worlds::new(&[world]).expect("one world"),
                name,
            }
        })
        .collect()
}

/// The smallest and greatest allowed genes, and those that count as 0, among others.
fn extreme(count: usize) -> Vec<f32> {
    let ends = [LEAST_GENE, 1e-30, 0.0, GREATEST_GENE];
    let mut genes = genes(0, count, 2.0);
    for (gene, end) in genes.iter_mut().step_by(4).zip(ends.into_iter().cycle()) {
        *gene = end * gene.signum();
    }
    genes
}

/// A row of round obstacles along each wall, more than 32 objects in total.
fn crowded(spec: &mut WorldSpec) {
    let row = |y: f32| (0..16).map(move |column| (60.0 + 32.0 * column as f32, y));
    spec.arena = Arena::rectangle(600.0, 350.0)
        .with_obstacles(row(12.0).chain(row(338.0)), 5.0)
        .called("crowded");
}

/// Lives in the simulator that is made from samples.
fn lives(controllers: &[Controller]) -> Vec<Subject> {
    let base = WorldSpec::miglino1995();
    let mut all: Vec<(String, WorldSpec)> = specs()
        .into_iter()
        .filter(|(_, spec)| spec.controller == base.controller)
        .collect();
    let mut with = |name: &str, change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = base.clone();
        change(&mut spec);
        all.push((name.to_owned(), spec));
    };
    let noisy = Noise {
        sensor: (-0.2, 0.2),
        motor: 0.1,
        ..Noise::CONSERVATIVE
    };
    let perceived = task(Speed::Signed, Difference::Square, Activation::Perceived);
    with("all noises", &|spec| spec.noise = noisy);
    with("turn first", &|spec| spec.robot.turn_before_move = 1.0);
    with("a walk through walls", &|spec| {
        (spec.noise.walk_range, spec.noise.walk_step) = (300.0, 250.0);
    });
    for arena in ["miglino1995-triangle", "open", "octagon"] {
        with(arena, &|spec| {
            spec.arena = Arena::named(arena).expect("it is in the catalogue");
            spec.noise = noisy;
        });
    }
    with("crowded", &crowded);
    with("crowded, all noises", &|spec| {
        crowded(spec);
        spec.noise = noisy;
    });
    with("asymmetric states", &|spec| {
        spec.robot.motors = MotorTable::khepera(MotorStates::Asymmetric20);
    });
    with("states rounded", &|spec| {
        spec.robot.motors = MotorTable::khepera(MotorStates::Evorobot21);
    });
    for (name, chosen) in tasks() {
        // Two exist under other names.
        if ![Task::AVOIDANCE, perceived].contains(&chosen) {
            with(&name, &|spec| {
                spec.noise.sensor = (0.0, 0.4);
                spec.task = chosen;
            });
        }
    }
    with("new cells of all words", &|spec| {
        spec.arena = Arena::rectangle(800.0, 400.0);
        spec.task = Task::AVOIDANCE.with_new_cell(1.0);
        // Fast and straight, to enter many cells.
        spec.cycles = 500;
        spec.noise = noisy;
    });
    all.extend(collisions());
    for (_, spec) in &mut all {
        spec.cycles = spec.cycles.min(250);
    }
    subjects(all, controllers, 6)
}

/// Every combination of terms.
fn tasks() -> Vec<(String, Task)> {
    let mut tasks = Vec::new();
    for speed in [Speed::Unsigned, Speed::Signed] {
        for difference in [Difference::Root, Difference::Square] {
            for activation in [Activation::Real, Activation::Perceived, Activation::None] {
                let name = format!("terms {speed:?}, {difference:?}, {activation:?}").to_lowercase();
                tasks.push((name, task(speed, difference, activation)));
            }
        }
    }
    tasks
}

/// Lives of surrogates.
fn surrogates(controllers: &[Controller]) -> Vec<Subject> {
    let base = WorldSpec {
        cycles: 100,
        ..WorldSpec::miglino1995()
    };
    let mut all = Vec::new();
    let mut with = |name: String, differences: Differences, change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = base.clone();
        spec.surrogate = Some(Arc::new(Surrogate::drawn(1, differences)));
        change(&mut spec);
        all.push((name, spec));
    };
    for severity in [0.0, 1.0, 2.0] {
        let differences = Differences::all(severity);
        for arena in ["miglino1995", "miglino1995-triangle", "open", "octagon"] {
            with(format!("{arena}, severity {severity}"), differences, &|spec| {
                spec.arena = Arena::named(arena).expect("it is in the catalogue");
            });
        }
        with(format!("a block, severity {severity}"), differences, &beside_a_block);
        with(format!("crowded, severity {severity}"), differences, &crowded);
    }
    for difference in surrogate::Difference::ALL {
        let name = difference.name();
        with(format!("only {name}"), Differences::only(1.0, difference), &|_| {});
    }
    let old = Differences::all(1.0).with_latency(100.0);
    with("old readings".into(), old, &|_| {});
    with("fixed start".into(), Differences::all(1.0), &|spec| {
        spec.start = Start::At {
            x: 60.0,
            y: 60.0,
            heading: 0.625,
        };
    });
    for (name, chosen) in tasks() {
        // A surrogate perceives the real activation.
        let perceives = |task| {
            matches!(
                task,
                Task::Avoidance {
                    activation: Activation::Perceived,
                    ..
                }
            )
        };
        if !perceives(chosen) && chosen != Task::AVOIDANCE {
            with(name, Differences::all(1.0), &|spec| spec.task = chosen);
        }
    }
    subjects(all, controllers, 4)
}

/// Two genes in hundredths, from each third for a robot with food and for one without.
fn thirds(rollout: u32) -> [f32; 2] {
    [rollout % 3, rollout / 3 % 3].map(|third| [0.0, 0.5, 0.99][third as usize])
}

/// On-board simulators with more items of food than eight.
fn foragers_with_many_items() -> Vec<Subject> {
    let food = |food_items, light| Foraging {
        food_items,
        ..Foraging::odowd2014(light)
    };
    subjects_of_foragers(vec![
        ("nine items".into(), food(9, Light::OverNest)),
        ("28 items, dark".into(), food(28, Light::Nowhere)),
        ("64 items".into(), food(64, Light::OppositeNest)),
    ])
}

/// On-board simulators of foragers.
fn foragers() -> Vec<Subject> {
    let mut all: Vec<(String, Foraging)> = Vec::new();
    for light in [Light::OverNest, Light::Nowhere, Light::OppositeNest] {
        let forager = Foraging::odowd2014(light);
        let quiet = Foraging {
            light_noise: 0.0,
            wheel_noise: 0.0,
            ..forager
        };
        all.push((format!("{light:?}"), forager));
        all.push((format!("{light:?}, no noise"), quiet));
    }
    let base = Foraging::odowd2014(Light::OverNest);
    let start = Some([100.0, -50.0, 0.3]);
    all.extend(
        [
            ("fixed start", Foraging { start, ..base }),
            ("no food", Foraging { food_items: 0, ..base }),
            ("eight items", Foraging { food_items: 8, ..base }),
            (
                "food at arm's length",
                Foraging {
                    food_radius: 200.0,
                    ..base
                },
            ),
            ("no way on after an escape", Foraging { escape: 0.0, ..base }),
            ("blind", Foraging { near: 0.0, ..base }),
            (
                "in the dark",
                Foraging {
                    ambient: 0.0,
                    light_noise: 0.0,
                    ..base
                },
            ),
            (
                "a threshold of light",
                Foraging {
                    phototaxis_threshold: 0.3,
                    ..base
                },
            ),
            (
                "a small arena",
                Foraging {
                    arena_radius: 250.0,
                    ..base
                },
            ),
        ]
        .map(|(name, forager)| (name.to_owned(), forager)),
    );
    subjects_of_foragers(all)
}

fn subjects_of_foragers(all: Vec<(String, Foraging)>) -> Vec<Subject> {
    all.into_iter()
        .map(|(name, forager)| Subject {
            worlds: Worlds::new(&[forager]).unwrap_or_else(|error| panic!("{name}: {error}")),
            genomes: (0..9).map(|rollout| thirds(rollout).into()).collect(),
            name,
        })
        .collect()
}

/// Behaviours of foragers whose readings are reported: each value that counts, alone.
fn behaviours() -> Vec<Subject> {
    let base = Foraging::odowd2014(Light::Nowhere);
    let all = [
        ("as in 2014", base),
        ("slow", Foraging { cruise: 20.0, ..base }),
        ("slow turns", Foraging { turn: 0.5, ..base }),
        (
            "a small gain",
            Foraging {
                phototaxis_gain: 0.5,
                ..base
            },
        ),
        (
            "slow turns to the light",
            Foraging {
                phototaxis_turn: 0.2,
                ..base
            },
        ),
        (
            "a threshold of light",
            Foraging {
                phototaxis_threshold: 0.9,
                ..base
            },
        ),
        ("blind", Foraging { near: 0.0, ..base }),
        (
            "turns often",
            Foraging {
                search_interval: 0.5,
                ..base
            },
        ),
    ];
    all.into_iter()
        .map(|(name, foraging)| Subject {
            worlds: Worlds::new(&[Behaviours { foraging, cycles: 200 }])
                .unwrap_or_else(|error| panic!("{name}: {error}")),
            genomes: (0..36).map(reported).collect(),
            name: name.into(),
        })
        .collect()
}

/// Genes and readings of a rollout: nothing near, something on one side, the same on both sides, or next to nothing; light that
/// differs from sensor to sensor; with food and without.
fn reported(rollout: u32) -> Vec<f32> {
    let number = |index: u32| (pcg4d([rollout, index, 0, 0x6163_7473])[0] >> 8) as f32 / 16_777_216.0;
    let near = match rollout % 4 {
        0 => [0.0; 4],
        1 => std::array::from_fn(|sensor| number(sensor as u32)),
        2 => [number(0); 4],
        _ => [0.05, 0.0, 0.01, LEAST_GENE / 2.0],
    };
    let light: [f32; 8] = std::array::from_fn(|sensor| number(4 + sensor as u32));
    let carries = f32::from(u8::from(rollout % 8 < 4));
    [&thirds(rollout / 4)[..], &near, &light, &[carries]].concat()
}

/// Worlds with several robots: ten as in the 2014 study, with each difference alone, and large swarms.
fn swarms() -> Vec<Subject> {
    const ALL: swarm::Differences = swarm::Differences::ODOWD2014;
    const NONE: swarm::Differences = swarm::Differences::NONE;
    let ten = Swarm::odowd2014(10);
    let differing = |differences| Swarm { differences, ..ten };
    let blind = |robots: u32, differences| Swarm {
        robots,
        forager: Foraging {
            near: 0.0,
            ..ten.forager
        },
        differences,
        ..ten
    };
    let all = [
        ("all differences", ten, 200),
        ("no difference", differing(NONE), 200),
        (
            "only wheels",
            differing(swarm::Differences {
                wheels: ALL.wheels,
                ..NONE
            }),
            200,
        ),
        (
            "only proximity",
            differing(swarm::Differences {
                proximity: ALL.proximity,
                ..NONE
            }),
            200,
        ),
        (
            "only light",
            differing(swarm::Differences {
                light: ALL.light,
                ..NONE
            }),
            200,
        ),
        (
            "only slip",
            differing(swarm::Differences { slip: ALL.slip, ..NONE }),
            200,
        ),
        (
            "only latency",
            differing(swarm::Differences { latency: true, ..NONE }),
            200,
        ),
        (
            "only beam",
            differing(swarm::Differences { beam: ALL.beam, ..NONE }),
            200,
        ),
        (
            "only reflection",
            differing(swarm::Differences {
                reflection: ALL.reflection,
                ..NONE
            }),
            200,
        ),
        (
            "only shadows",
            differing(swarm::Differences {
                shadows: ALL.shadows,
                ..NONE
            }),
            200,
        ),
        (
            "only tracking loss",
            differing(swarm::Differences {
                tracking_loss: 0.5,
                ..NONE
            }),
            200,
        ),
        ("other individuals", Swarm { individuals: 2, ..ten }, 200),
        (
            "a threshold of light",
            Swarm {
                forager: Foraging {
                    phototaxis_threshold: 0.3,
                    ..ten.forager
                },
                ..ten
            },
            200,
        ),
        (
            "heard through others",
            Swarm {
                line_of_sight: false,
                heard: 1.0,
                ..ten
            },
            200,
        ),
        ("nobody is heard", Swarm { heard: 0.0, ..ten }, 200),
        ("short intervals", Swarm { interval: 20, ..ten }, 200),
        ("one robot", Swarm { robots: 1, ..ten }, 200),
        ("a blind crowd", blind(50, NONE), 200),
        ("a crowd", Swarm { robots: 50, ..ten }, 100),
        // Software drivers reject this many robots, because they limit loop iterations.
        ("as many as there can be", blind(128, ALL), 20),
    ];
    all.into_iter()
        .map(|(name, mut swarm, cycles)| {
            swarm.forager.cycles = cycles;
            Subject {
                name: name.into(),
                worlds: Worlds::new(&[swarm]).unwrap_or_else(|error| panic!("{name}: {error}")),
                genomes: (0..3).map(|rollout| orders(&swarm, rollout, cycles)).collect(),
            }
        })
        .collect()
}

/// A world's lamp, which may move, and its robots' orders: some are switched on later, most get other genes.
fn orders(swarm: &Swarm, rollout: u32, cycles: u32) -> Vec<f32> {
    let lights = [Light::OverNest, Light::Nowhere, Light::OppositeNest];
    let lamp = Lamp {
        first: lights[rollout as usize],
        then: lights[(rollout as usize + 1) % 3],
        moves: cycles / 2,
    };
    let order = |robot: u32| {
        let [word, other, at, begins] = pcg4d([rollout, robot, 0, 0x7377_6d73]);
        Order {
            before: (robot % 4 != 3).then(|| thirds(word)),
            after: thirds(other),
            at: if robot % 4 == 2 { 0 } else { at % cycles },
            begins: robot.is_multiple_of(2).then_some(begins % cycles),
        }
    };
    let orders: Vec<Order> = (0..swarm.robots).map(order).collect();
    swarm.inputs(&lamp, &orders)
}
