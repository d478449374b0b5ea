//! Networks described by their layers: each cycle against formulas in double precision that find every gene by its name, the same
//! bits on every device, and what is refused.

use std::collections::HashMap;

use crate::composed::Subject;
use crate::lives::{self, batch, world};
use oneiro::batch::{Batch, Trace};
use oneiro::compose::{DetailKind, Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Sensor};
use oneiro::evaluator::{Control, Evaluator};
#[cfg(feature = "gpu")]
use oneiro::gpu::{Choice, Gpu};
use oneiro::network::{Activation, Layer, LayerKind, Network, Outputs};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::tables::SENSOR_NAMES;
use oneiro::world::{Controller, Noise, World, WorldSpec};

fn layer(kind: LayerKind, units: u32) -> Layer {
    Layer {
        kind,
        units,
        ..Layer::default()
    }
}

fn dense(units: u32, activation: Activation) -> Layer {
    Layer {
        activation: Some(activation),
        ..layer(LayerKind::Dense, units)
    }
}

fn sensor(name: &str) -> Sensor {
    Sensor {
        name: name.into(),
        range: Some(100.0),
        ..Sensor::default()
    }
}

/// Every kind of layer, first and after another, with every activation function, with and without biases.
pub(crate) fn networks() -> Vec<Network> {
    let with = |layers: &[Layer]| Network {
        layers: layers.to_vec(),
        ..Network::default()
    };
    let without_biases = |layer: Layer| Layer {
        biases: Some(false),
        ..layer
    };
    vec![
        with(&[]),
        Network {
            activation: Some(Activation::Linear),
            slope: Some(0.05),
            ..with(&[])
        },
        Network {
            activation: Some(Activation::Tanh),
            ..with(&[
                dense(5, Activation::Relu),
                dense(3, Activation::Tanh),
                dense(4, Activation::Logistic),
            ])
        },
        Network {
            activation: Some(Activation::Relu),
            slope: Some(0.25),
            ..with(&[without_biases(dense(3, Activation::Linear)), dense(2, Activation::Step)])
        },
        Network {
            activation: Some(Activation::Step),
            ..with(&[Layer {
                slope: Some(0.3),
                activation: Some(Activation::Tanh),
                ..layer(LayerKind::Elman, 4)
            }])
        },
        with(&[dense(3, Activation::Tanh), without_biases(layer(LayerKind::Elman, 3))]),
        Network {
            outputs: Some(Outputs::FirstTwo),
            ..with(&[layer(LayerKind::Ctrnn, 5)])
        },
        with(&[
            dense(2, Activation::Relu),
            without_biases(Layer {
                time_constants: Some([0.2, 30.0]),
                ..layer(LayerKind::Ctrnn, 3)
            }),
        ]),
        with(&[layer(LayerKind::Lstm, 3)]),
        Network {
            outputs: Some(Outputs::FirstTwo),
            ..with(&[layer(LayerKind::Elman, 3), without_biases(layer(LayerKind::Lstm, 2))])
        },
        Network {
            outputs: Some(Outputs::FirstTwo),
            ..with(&[dense(2, Activation::Linear)])
        },
        with(&[layer(LayerKind::Plastic, 3)]),
        Network {
            outputs: Some(Outputs::FirstTwo),
            ..with(&[
                dense(3, Activation::Relu),
                without_biases(Layer {
                    slope: Some(2.0),
                    initial_strengths: Some([0.2, 1.0]),
                    ..layer(LayerKind::Plastic, 2)
                }),
            ])
        },
    ]
}

fn of(network: &Network, change: impl Fn(&mut WorldSpec)) -> World {
    world(60, |spec| {
        spec.controller = Controller::Network(network.clone());
        spec.noise = Noise::SENSOR;
        change(spec);
    })
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

fn activated(activation: Option<Activation>, slope: Option<f32>, sum: f64) -> f64 {
    let x = f64::from(slope.unwrap_or(1.0)) * sum;
    match activation.unwrap_or_default() {
        Activation::Logistic => logistic(x),
        Activation::Tanh => x.tanh(),
        Activation::Relu => x.clamp(0.0, 1000.0),
        Activation::Linear => x.clamp(-1000.0, 1000.0),
        Activation::Step => f64::from(u8::from(x > 0.0)),
    }
}

/// A synapse's strength after a cycle, by the formulas of Floreano and Urzelai (2000).
fn learnt(rule: f64, rate: f64, w: f64, x: f64, y: f64) -> f64 {
    let hebb = (1.0 - w) * x * y;
    let change = match (4.0 * rule).clamp(0.0, 3.0) as u32 {
        0 => hebb,
        1 => hebb + w * (x - 1.0) * y,
        2 => hebb + w * x * (y - 1.0),
        _ => {
            let covariance = (4.0 * (1.0 - (x - y).abs()) - 2.0).tanh();
            if covariance > 0.0 {
                (1.0 - w) * covariance
            } else {
                w * covariance
            }
        }
    };
    w + rate.clamp(0.0, 1.0) * change
}

/// A cycle of a network, by the names of genes and of what units remember.
struct Cycle<'a> {
    gene: &'a HashMap<String, f64>,
    before: &'a HashMap<String, f64>,
    after: HashMap<String, f64>,
}

impl Cycle<'_> {
    fn remembered(&self, name: &str) -> f64 {
        self.before.get(name).copied().unwrap_or(0.0)
    }

    /// The sum of named inputs, each times its gene, and of a bias if there is one.
    fn sum(&self, inputs: &[(String, f64)], to: &str) -> f64 {
        let weighed = inputs
            .iter()
            .map(|(name, value)| self.gene[&format!("{name}_to_{to}")] * value);
        weighed.sum::<f64>() + self.gene.get(&format!("bias_{to}")).unwrap_or(&0.0)
    }

    /// The outputs of a layer.
    fn layer(&mut self, index: usize, layer: &Layer, inputs: &[(String, f64)]) -> Vec<(String, f64)> {
        let units: Vec<_> = (0..layer.units)
            .map(|unit| format!("layer_{index}_unit_{unit}"))
            .collect();
        let state = |unit: u32| format!("layer_{index}_state_{unit}");
        let cell = |unit: u32| format!("layer_{index}_cell_{unit}");
        let bias = |own: &Self, unit: &str| own.gene.get(&format!("bias_{unit}")).copied().unwrap_or(0.0);
        let past = |unit: u32| {
            let name = units[unit as usize].clone();
            let output = match layer.kind {
                LayerKind::Ctrnn => logistic(self.remembered(&state(unit)) + bias(self, &name)),
                _ => self.remembered(&name),
            };
            (name, output)
        };
        let mut all = inputs.to_vec();
        if layer.kind != LayerKind::Dense {
            all.extend((0..layer.units).map(past));
        }
        let mut outputs = Vec::new();
        for (unit, name) in (0..layer.units).zip(&units) {
            let output = match layer.kind {
                LayerKind::Dense => activated(layer.activation, layer.slope, self.sum(&all, name)),
                LayerKind::Elman => {
                    let output = activated(layer.activation, layer.slope, self.sum(&all, name));
                    self.after.insert(name.clone(), output);
                    output
                }
                LayerKind::Ctrnn => {
                    let [least, greatest] = layer.time_constants.unwrap_or([0.1, 5.0]).map(f64::from);
                    let share = self.gene[&format!("time_constant_{name}")].clamp(0.0, 1.0);
                    let tau = least * (greatest / least).powf(share);
                    let before = self.remembered(&state(unit));
                    let sum = self.sum(&all, name) - bias(self, name);
                    let now = before + 0.1 / tau * (sum - before);
                    self.after.insert(state(unit), now);
                    logistic(now + bias(self, name))
                }
                LayerKind::Lstm => {
                    let sum = |gate: &str| self.sum(&all, &format!("{name}_{gate}"));
                    let kept = logistic(sum("forget_gate") + 1.0) * self.remembered(&cell(unit));
                    let now = kept + logistic(sum("input_gate")) * sum("candidate").tanh();
                    let output = logistic(sum("output_gate")) * now.tanh();
                    self.after.insert(cell(unit), now);
                    self.after.insert(name.clone(), output);
                    output
                }
                LayerKind::Plastic => {
                    let strength =
                        |synapse: usize| format!("layer_{index}_strength_{}", unit as usize * all.len() + synapse);
                    let weight = |source: &str| self.gene[&format!("{source}_to_{name}")];
                    let synapses = all.iter().enumerate();
                    let weighed = synapses
                        .clone()
                        .map(|(synapse, (source, x))| weight(source) * self.remembered(&strength(synapse)) * x);
                    let sum = weighed.sum::<f64>() + bias(self, name);
                    let output = logistic(f64::from(layer.slope.unwrap_or(1.0)) * sum);
                    for (synapse, (source, x)) in synapses {
                        let [rule, rate] =
                            ["rule", "rate"].map(|what| self.gene[&format!("{what}_{source}_to_{name}")]);
                        let w = self.remembered(&strength(synapse));
                        self.after
                            .insert(strength(synapse), learnt(rule, rate, w, x.clamp(0.0, 1.0), output));
                    }
                    self.after.insert(name.clone(), output);
                    output
                }
            };
            outputs.push((name.clone(), output));
        }
        outputs
    }

    /// Commands of the two wheels.
    fn commands(&mut self, network: &Network, readings: Vec<(String, f64)>) -> [f64; 2] {
        let mut values = readings;
        for (index, layer) in network.layers.iter().enumerate() {
            values = self.layer(index, layer, &values);
        }
        let is_speed = |activation: Option<Activation>| {
            !matches!(activation, None | Some(Activation::Logistic | Activation::Step))
        };
        let command = |value: f64, is_speed: bool| if is_speed { 0.5 + 0.5 * value } else { value }.clamp(0.0, 1.0);
        match (network.outputs, network.layers.last()) {
            (Some(Outputs::FirstTwo), Some(last)) => {
                let is_speed = match last.kind {
                    LayerKind::Ctrnn | LayerKind::Plastic => false,
                    LayerKind::Lstm => true,
                    LayerKind::Dense | LayerKind::Elman => is_speed(last.activation),
                };
                [0, 1].map(|unit: usize| command(values[unit].1, is_speed))
            }
            _ => ["left", "right"].map(|to| {
                let sum = self.sum(&values, to);
                command(
                    activated(network.activation, network.slope, sum),
                    is_speed(network.activation),
                )
            }),
        }
    }
}

/// What a record's details say of the controller's memory, and of the readings that it got.
fn details(world: &World, trace: &Trace, record: usize, kind: DetailKind) -> Vec<(String, f64)> {
    let all = world.details().iter().zip(trace.details(record));
    all.filter(|(detail, _)| detail.kind == kind)
        .map(|(detail, word)| (detail.name.clone(), f64::from(f32::from_bits(*word))))
        .collect()
}

#[test]
fn each_cycle_is_that_of_the_formulas() {
    for network in networks() {
        let world = of(&network, |_| {});
        let batch = batch(std::slice::from_ref(&world), 20, Some(1));
        let traces = Cpu::new(Some(2))
            .unwrap()
            .evaluate(&batch, &Control::new())
            .unwrap()
            .traces;
        let names = world.gene_layout().names();
        let (mut borders, mut lowest, mut highest) = (0, 1.0_f32, 0.0_f32);
        for (life, trace) in traces.iter().enumerate() {
            let genes = lives::genes(life, names.len()).into_iter().map(f64::from);
            let gene: HashMap<_, _> = names.iter().cloned().zip(genes).collect();
            let memory = |step| -> HashMap<_, _> {
                let memory = details(&world, trace, step, DetailKind::Memory(Kind::Controller));
                memory.into_iter().collect()
            };
            // What the first cycle of a plastic network weighs is drawn in it.
            let is_plastic = network.layers.iter().any(|layer| layer.kind == LayerKind::Plastic);
            let first = usize::from(is_plastic);
            let mut before = if is_plastic { memory(0) } else { HashMap::new() };
            for (step, record) in trace.iter().enumerate().skip(first) {
                let readings = details(&world, trace, step, DetailKind::Perceived);
                let readings = SENSOR_NAMES
                    .iter()
                    .zip(readings)
                    .map(|(name, (_, value))| (name.to_string(), value));
                let mut cycle = Cycle {
                    gene: &gene,
                    before: &before,
                    after: HashMap::new(),
                };
                let commands = cycle.commands(&network, readings.collect());
                let after = cycle.after;
                let memory = memory(step);
                let is_near = |a: f64, b: f64| (a - b).abs() < 2e-5 * (1.0 + a.abs());
                let is_right = is_near(commands[0], record.left.into())
                    && is_near(commands[1], record.right.into())
                    && after.iter().all(|(name, value)| is_near(*value, memory[name]));
                // A step function may see a sum of nearly 0 on either side of it.
                borders += u32::from(!is_right);
                let has_steps = network.activation == Some(Activation::Step)
                    || network
                        .layers
                        .iter()
                        .any(|layer| layer.activation == Some(Activation::Step));
                assert!(
                    is_right || has_steps,
                    "{network:?}: {commands:?} {record:?} {after:?} {memory:?}"
                );
                assert_eq!(after.len(), memory.len() - usize::from(memory.contains_key("unused")));
                before = memory;
                lowest = lowest.min(record.left).min(record.right);
                highest = highest.max(record.left).max(record.right);
            }
        }
        assert!(borders < 3, "{borders} of 1200 cycles differ");
        assert!(highest - lowest > 0.4, "{network:?} does little: {lowest} to {highest}");
    }
}

/// Without layers it is the perceptron, and in the simulators that ship with their own physics as well.
#[test]
fn a_network_without_layers_has_the_perceptrons_bits() {
    let surrogate = |spec: &mut WorldSpec| {
        spec.noise = Noise::NONE;
        spec.surrogate = Some(Surrogate::drawn(3, Differences::all(1.0)).into());
    };
    for change in [&|_: &mut WorldSpec| {}, &surrogate as &dyn Fn(&mut WorldSpec)] {
        let network = of(&Network::default(), change);
        let shipped = world(60, |spec| {
            spec.noise = Noise::SENSOR;
            change(spec);
        });
        assert_eq!(network.gene_layout(), shipped.gene_layout());
        let fitness = |world: &World| {
            let batch = batch(std::slice::from_ref(world), 200, None);
            Cpu::new(Some(2))
                .unwrap()
                .evaluate(&batch, &Control::new())
                .unwrap()
                .fitness
        };
        assert_eq!(fitness(&network), fitness(&shipped));
    }
}

/// Synapses that do not learn have the strengths that were drawn as their episode began, and at full strength their bits are an
/// Elman network's.
#[test]
fn strengths_are_drawn_as_an_episode_begins() {
    let of_kind = |kind, initial_strengths| {
        let layers = vec![Layer {
            initial_strengths,
            ..layer(kind, 3)
        }];
        let network = Network {
            layers,
            ..Network::default()
        };
        of(&network, |_| {})
    };
    let lived = |world: &World, genes: &dyn Fn(usize, &str) -> f32| {
        let names = world.gene_layout().names();
        let change = |life, all: &mut [f32]| {
            for (gene, name) in all.iter_mut().zip(&names) {
                *gene = genes(life, name);
            }
        };
        let batch = lives::batch_with(std::slice::from_ref(world), 100, Some(1), change);
        Cpu::new(Some(2)).unwrap().evaluate(&batch, &Control::new()).unwrap()
    };
    let without_learning = |life: usize, name: &str| {
        let sum = name
            .bytes()
            .fold(life as u32, |sum, byte| sum.wrapping_mul(31) + u32::from(byte));
        if name.starts_with("rate_") {
            0.0
        } else {
            (sum % 61) as f32 / 10.0 - 3.0
        }
    };

    let range = [0.25, 0.75];
    let world = of_kind(LayerKind::Plastic, Some(range));
    let mut drawn: Vec<u64> = Vec::new();
    for trace in &lived(&world, &without_learning).traces {
        let memory = |step| {
            let memory = details(&world, trace, step, DetailKind::Memory(Kind::Controller)).into_iter();
            let strengths = memory.filter(|(name, _)| name.contains("strength"));
            strengths.map(|(_, strength)| strength).collect::<Vec<_>>()
        };
        let first = memory(0);
        assert_eq!(first.len(), 3 * (8 + 3));
        assert_eq!(first, memory(trace.len() - 1));
        assert!(
            first.iter().all(|strength| (0.25..0.75).contains(strength)),
            "{first:?}"
        );
        drawn.extend(first.into_iter().map(f64::to_bits));
    }
    let all = drawn.len() as f64;
    let mean = drawn.iter().map(|bits| f64::from_bits(*bits)).sum::<f64>() / all;
    // Of numbers that are uniform in this range the standard deviation is 0.5 / sqrt(12).
    assert!((mean - 0.5).abs() < 4.0 * 0.5 / (12.0 * all).sqrt(), "{mean}");
    drawn.sort_unstable();
    drawn.dedup();
    assert!(drawn.len() as f64 > 0.99 * all, "{} of {all} differ", drawn.len());

    let strong = lived(&of_kind(LayerKind::Plastic, Some([1.0, 1.0])), &without_learning);
    let elman = lived(&of_kind(LayerKind::Elman, None), &without_learning);
    assert_eq!(strong.fitness, elman.fitness);
    let learning = |life, name: &str| {
        if name.starts_with("rate_") {
            0.5
        } else {
            without_learning(life, name)
        }
    };
    assert_ne!(
        lived(&of_kind(LayerKind::Plastic, Some([1.0, 1.0])), &learning).fitness,
        elman.fitness
    );
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let large = Subject::new("large", 70, 2, of_large).without_gpu();
    let subject = |(index, network): (usize, &Network)| {
        let world = of(network, |_| {});
        Subject::new(format!("network {index}"), 200, 4, |episodes| {
            batch(std::slice::from_ref(&world), episodes, Some(1))
        })
    };
    networks().iter().enumerate().map(subject).chain([large]).collect()
}

/// As many units of a layer, and as many genes, as there may be.
fn large() -> Network {
    let layer = |units| Layer {
        biases: Some(false),
        ..dense(units, Activation::Tanh)
    };
    Network {
        layers: vec![layer(1024), layer(56)],
        outputs: Some(Outputs::FirstTwo),
        ..Network::default()
    }
}

/// Episodes of as many such networks.
fn of_large(episodes: usize) -> Batch {
    let world = world(3, |spec| spec.controller = Controller::Network(large()));
    let small = |_, genes: &mut [f32]| genes.iter_mut().for_each(|gene| *gene *= 0.1);
    lives::batch_with(std::slice::from_ref(&world), episodes, Some(1), small)
}

/// A software driver takes minutes to compile it.
#[cfg(feature = "gpu")]
#[test]
#[ignore = "takes minutes: tests/long.sh"]
fn the_largest_network_has_the_same_bits_on_a_gpu() {
    let mut gpu = Gpu::open(&Choice::Best).expect("this test needs an adapter");
    let batch = of_large(70);
    let lived = |evaluator: &mut dyn Evaluator| {
        let outcome = evaluator.evaluate(&batch, &Control::new()).unwrap();
        let words: Vec<u32> = outcome.traces.iter().flat_map(Trace::words).collect();
        (outcome.fitness, words)
    };
    assert!(lived(&mut gpu) == lived(&mut Cpu::new(Some(2)).unwrap()));
}

/// Of each kind of layer as many units as the genes allow run, and one more is refused.
#[test]
fn networks_are_as_large_as_their_genes_allow() {
    let largest = world(2, |spec| spec.controller = Controller::Network(large()));
    assert_eq!(largest.genes(), 65_536);
    for (kind, units) in [
        (LayerKind::Dense, 1024),
        (LayerKind::Elman, 250),
        (LayerKind::Ctrnn, 250),
        (LayerKind::Lstm, 123),
        // 28 (8 + 28) synapses.
        (LayerKind::Plastic, 28),
    ] {
        let of = |units| Network {
            layers: vec![layer(kind, units)],
            ..Network::default()
        };
        let world = world(2, |spec| spec.controller = Controller::Network(of(units)));
        let outcome = Cpu::new(Some(1))
            .unwrap()
            .evaluate(&batch(std::slice::from_ref(&world), 2, Some(1)), &Control::new());
        let commands = outcome
            .unwrap()
            .traces
            .iter()
            .flatten()
            .map(|record| record.left)
            .collect::<Vec<_>>();
        assert!(
            commands.len() == 4 && commands[0] != commands[2],
            "{kind:?}: {commands:?}"
        );
        let more = WorldSpec {
            controller: Controller::Network(of(units + 1)),
            ..WorldSpec::miglino1995()
        };
        let refused = World::new(more).unwrap_err().to_string();
        assert!(
            refused.contains("; allowed: 1 to ")
                || refused.contains("have 1073 synapses that learn; allowed: up to 1024"),
            "{kind:?}: {refused}"
        );
    }
}

#[test]
fn genes_have_names_and_time_constants_a_range() {
    let layouts = [
        ("plastic", layer(LayerKind::Plastic, 3), 3 * (3 * (8 + 3) + 1) + 2 * 4),
        ("lstm", layer(LayerKind::Lstm, 2), 2 * 4 * (8 + 2 + 1) + 2 * 3),
        ("ctrnn", layer(LayerKind::Ctrnn, 3), 3 * (8 + 3 + 1 + 1) + 2 * 4),
        ("elman", layer(LayerKind::Elman, 3), 3 * (8 + 3 + 1) + 2 * 4),
        ("dense", layer(LayerKind::Dense, 3), 3 * (8 + 1) + 2 * 4),
    ];
    for (name, layer, genes) in layouts {
        let network = Network {
            layers: vec![layer],
            ..Network::default()
        };
        let layout = of(&network, |_| {}).gene_layout().clone();
        let mut names = layout.names();
        assert_eq!((names.len(), layout.genes()), (genes, genes), "{name}");
        let with_range = layout
            .ranges()
            .iter()
            .filter(|range| **range == Some([0.0, 1.0]))
            .count();
        let expected = match name {
            "ctrnn" => 3,
            "plastic" => 2 * 3 * (8 + 3),
            _ => 0,
        };
        assert_eq!(with_range, expected, "{name}");
        names.sort();
        names.dedup();
        assert_eq!(names.len(), genes, "{name}: each name once");
    }
}

/// Slopes and time constants are values, so that a sweep of them has one kernel and its runs share batches.
#[test]
fn networks_that_differ_in_numbers_share_a_kernel() {
    let with = |slope: f32, time_constants| Network {
        layers: vec![
            Layer {
                slope: Some(slope),
                activation: Some(Activation::Tanh),
                ..layer(LayerKind::Elman, 3)
            },
            Layer {
                time_constants,
                ..layer(LayerKind::Ctrnn, 2)
            },
        ],
        slope: Some(2.0 * slope),
        ..Network::default()
    };
    let numbers = [
        (0.3, None),
        (0.4, None),
        (0.3, Some([0.2, 30.0])),
        (1.0, Some([1.0, 1.0])),
    ];
    let worlds = numbers.map(|(slope, time_constants)| of(&with(slope, time_constants), |_| {}));
    assert!(worlds.iter().all(|own| std::ptr::eq(own.kernel(), worlds[0].kernel())));
    let fitness = |worlds: &[World]| {
        let outcome = Cpu::new(Some(2))
            .unwrap()
            .evaluate(&batch(worlds, 60, None), &Control::new());
        outcome.unwrap().fitness
    };
    let alone = worlds.each_ref().map(|own| fitness(std::slice::from_ref(own)));
    for (one, other) in [(0, 1), (0, 2), (2, 3)] {
        assert_ne!(alone[one], alone[other], "the numbers show");
    }
    let together = fitness(&worlds);
    for (index, own) in together.iter().enumerate() {
        assert_eq!(own.to_bits(), alone[index % worlds.len()][index].to_bits());
    }
}

/// Readings name genes, and so do units.
#[test]
fn a_reading_that_names_two_genes_alike_is_refused() {
    let named = |name: &str| {
        let text = format!(
            "struct SensorReadings {{ {name}: f32 }}
            fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {{
                return Sensed(SensorReadings(0.5f), before);
            }}"
        );
        let part = Part::new(Kind::Sensor, "own.wgsl", &text).unwrap();
        let mut robot = Differential::new(60.0, 100.0);
        robot.sensors = ["ahead", name].map(sensor).to_vec();
        let own = OwnParts::from([OwnPart::new(part.into(), &[]).unwrap()]);
        (own, Build::Differential(robot))
    };
    let refused = |name: &str, kind: LayerKind, is_described: bool| {
        let (own, build) = named(name);
        let mut spec = WorldSpec {
            controller: Controller::Network(Network {
                layers: vec![layer(kind, 3)],
                ..Network::default()
            }),
            ..WorldSpec::miglino1995()
        };
        if is_described {
            spec.robot.build = build;
        } else {
            spec.own = own;
        }
        World::new(spec).map_or_else(|invalid| invalid.to_string(), |_| String::new())
    };
    let problem = "the reading `layer_0_unit_1` gives two genes of the network the name `layer_0_unit_1_to_layer_0_unit_0`; \
                   allowed: another reading's name";
    let name = "layer_0_unit_1";
    assert_eq!(
        refused(name, LayerKind::Elman, true),
        format!("robot.sensors[1].name: {problem}")
    );
    assert_eq!(
        refused(name, LayerKind::Elman, false),
        format!("sensor.part: {problem}")
    );
    assert_eq!(refused(name, LayerKind::Dense, true), "");
    assert_eq!(refused("layer_0_unit_3", LayerKind::Elman, false), "");
    let rule = refused("rule_ahead", LayerKind::Plastic, true);
    assert!(rule.contains("the name `rule_ahead_to_layer_0_unit_0`"), "{rule}");
}

#[test]
fn mistakes_are_refused() {
    let first_two = |layers: Vec<Layer>| Network {
        layers,
        outputs: Some(Outputs::FirstTwo),
        ..Network::default()
    };
    let with = |layer: Layer| Network {
        layers: vec![layer],
        ..Network::default()
    };
    let ctrnn = layer(LayerKind::Ctrnn, 2);
    let cases = [
        (
            first_two(vec![]),
            "controller.outputs: is `first_two`, but the last layer has fewer than two units; allowed: `weighted`",
        ),
        (
            first_two(vec![layer(LayerKind::Dense, 1)]),
            "controller.outputs: is `first_two`, but the last layer has fewer than two units; allowed: `weighted`",
        ),
        (
            Network {
                slope: Some(2.0),
                ..first_two(vec![ctrnn.clone()])
            },
            "controller.slope: is given; allowed: not with outputs = \"first_two\"",
        ),
        (
            with(Layer {
                activation: Some(Activation::Tanh),
                ..layer(LayerKind::Lstm, 2)
            }),
            "controller.layers[0].activation: is given; allowed: not with kind = \"lstm\"",
        ),
        (
            with(Layer {
                time_constants: Some([1.0, 2.0]),
                ..layer(LayerKind::Elman, 2)
            }),
            "controller.layers[0].time_constants_s: is given; allowed: not with kind = \"elman\"",
        ),
        (
            with(Layer {
                time_constants: Some([2.0, 1.0]),
                ..ctrnn.clone()
            }),
            "controller.layers[0].time_constants_s: is [2, 1]; allowed: [minimum, maximum]",
        ),
        (
            with(Layer {
                time_constants: Some([0.05, 1.0]),
                ..ctrnn.clone()
            }),
            "controller.layers[0].time_constants_s: is 0.05; allowed: 0.1 to 100000",
        ),
        (
            with(Layer {
                initial_strengths: Some([0.0, 1.0]),
                ..ctrnn
            }),
            "controller.layers[0].initial_strengths: is given; allowed: not with kind = \"ctrnn\"",
        ),
        (
            with(Layer {
                initial_strengths: Some([0.5, 0.2]),
                ..layer(LayerKind::Plastic, 2)
            }),
            "controller.layers[0].initial_strengths: is [0.5, 0.2]; allowed: [minimum, maximum]",
        ),
        (
            with(Layer {
                activation: Some(Activation::Tanh),
                ..layer(LayerKind::Plastic, 2)
            }),
            "controller.layers[0].activation: is given; allowed: not with kind = \"plastic\"",
        ),
        (
            with(layer(LayerKind::Dense, 1025)),
            "controller.layers[0].units: is 1025; allowed: 1 to 1024",
        ),
        (
            with(layer(LayerKind::Lstm, 128)),
            "controller.layers: make 70402 genes; allowed: 1 to 65536",
        ),
        (
            with(layer(LayerKind::Dense, 0)),
            "controller.layers[0].units: is 0; allowed: 1 to 1024",
        ),
        (
            Network {
                layers: vec![layer(LayerKind::Dense, 2); 9],
                ..Network::default()
            },
            "controller.layers: has 9 elements; allowed: up to 8",
        ),
    ];
    for (network, message) in cases {
        let refused = World::new(WorldSpec {
            controller: Controller::Network(network),
            ..WorldSpec::miglino1995()
        });
        assert_eq!(refused.unwrap_err().to_string(), message);
    }
}
