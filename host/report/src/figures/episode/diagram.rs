//! The diagram of a robot's controller: a network's nodes and weights, a state machine's states and arrows, or a behaviour tree's
//! branches.

use std::collections::BTreeMap;

use oneiro::automode::{Behaviour, Condition, Form, Machine, MachineState, Tree};
use oneiro::exact::{exponential, logarithm};
use oneiro::network::{Activation, Layer, LayerKind, Outputs, TIME_CONSTANTS, rule};
use oneiro::parameter::Choice;
use oneiro::world::{Controller, World};
use serde_json::{Value, json};

use super::SPEEDS;
use crate::numbers::{fixed, significant};

/// Nodes of the largest drawn network.
const NODES: usize = 60;
const OUTPUTS: [&str; 2] = ["left", "right"];

/// The names of a machine's states or a tree's branches; empty of other controllers.
pub(super) fn states(world: &World, genes: &[f32]) -> Vec<String> {
    let behaviours = Form::of(world.gene_layout()).map_or_else(Vec::new, |form| form.behaviours(genes));
    behaviours
        .into_iter()
        .enumerate()
        .map(|(number, own)| state(number, own))
        .collect()
}

/// Its name: the number and the behaviour.
fn state(number: usize, behaviour: Behaviour) -> String {
    format!("{number} {}", behaviour.word())
}

/// The diagram of a controller with these genes. `None`: its structure is unknown, or it is too large. `readings` names the page's
/// readings, of which the first ones are the controller's inputs.
pub(super) fn diagram(world: &World, genes: &[f32], readings: &[&str], inputs: usize) -> Option<Value> {
    match Form::of(world.gene_layout()) {
        Some(Form::StateMachine) => Some(machine(&Machine::of(genes))),
        Some(Form::BehaviourTree) => Some(tree(&Tree::of(genes))),
        None => network(world, genes, readings, inputs),
    }
}

fn machine(machine: &Machine) -> Value {
    let states = machine.states.iter().enumerate();
    let arrows = states.clone().flat_map(|(from, own)| {
        let arrow = move |to: usize, condition| {
            let [short, long] = words_of_condition(condition);
            // Transitions count the other states.
            json!([from, to + usize::from(to >= from), short, long])
        };
        own.transitions.iter().map(move |own| arrow(own.to, own.condition))
    });
    let shown = |(number, own): (usize, &MachineState)| {
        json!([state(number, own.behaviour), words_of_behaviour(own.behaviour)])
    };
    json!({ "kind": "machine", "states": states.clone().map(shown).collect::<Vec<_>>(), "arrows": arrows.collect::<Vec<_>>() })
}

fn tree(tree: &Tree) -> Value {
    let branches = tree.branches.iter().enumerate();
    let shown = branches
        .clone()
        .map(|(number, own)| json!([state(number, own.behaviour), words_of_behaviour(own.behaviour)]));
    let conditions = branches
        .clone()
        .map(|(_, own)| json!(words_of_condition(own.condition)));
    json!({ "kind": "tree", "states": shown.collect::<Vec<_>>(), "conditions": conditions.collect::<Vec<_>>() })
}

/// What a behaviour's values mean.
fn words_of_behaviour(behaviour: Behaviour) -> String {
    match behaviour {
        Behaviour::Exploration { turning } => {
            format!("exploration: straight ahead; at obstacles turns for up to {turning} cycles")
        }
        Behaviour::Attraction { strength } | Behaviour::Repulsion { strength } => {
            format!("{}: strength {}", behaviour.word(), number(strength))
        }
        _ => behaviour.word().to_owned(),
    }
}

/// A condition in few words, and in all.
fn words_of_condition(condition: Condition) -> [String; 2] {
    let floor = |grey: &str, p: f32| {
        let long = format!("on a {grey} floor with probability {}", number(p));
        [format!("{grey} floor {}", fixed(p.into(), 2)), long]
    };
    match condition {
        Condition::BlackFloor(p) => floor("black", p),
        Condition::GreyFloor(p) => floor("grey", p),
        Condition::WhiteFloor(p) => floor("white", p),
        Condition::NeighbourCount(crowd) => {
            let (count, steepness) = (crowd.neighbours, number(crowd.steepness));
            let long = format!("with probability 1 / (1 + e^({steepness} ({count} - n))) for n robots heard");
            [format!("neighbours > {count}"), long]
        }
        Condition::InvertedNeighbourCount(crowd) => {
            let (count, steepness) = (crowd.neighbours, number(crowd.steepness));
            let long = format!("with probability 1 - 1 / (1 + e^({steepness} ({count} - n))) for n robots heard");
            [format!("neighbours < {count}"), long]
        }
        Condition::FixedProbability(p) => {
            let long = format!("with probability {}", number(p));
            [format!("chance {}", fixed(p.into(), 2)), long]
        }
    }
}

fn number(x: f32) -> String {
    significant(x.into(), 3)
}

/// A network's nodes, in the order in which their values follow from each other, and the lines between them.
struct Drawn<'a> {
    /// Those without a line so far, by name.
    genes: BTreeMap<&'a str, f32>,
    nodes: Vec<Node>,
    lines: Vec<Value>,
}

/// A part of a network that has a value: a reading of the page or its lines' sum, to which `shift` is added; then the function.
#[derive(Default)]
struct Node {
    name: String,
    column: usize,
    reading: Option<usize>,
    shift: f32,
    function: Option<Activation>,
    slope: Option<f32>,
    /// Of an output: the wheel, and the value at which it stands.
    wheel: Option<(&'static str, f32)>,
}

impl Node {
    fn new(name: &str, column: usize, reading: Option<usize>) -> Self {
        Self {
            name: name.to_owned(),
            column,
            reading,
            ..Self::default()
        }
    }

    fn facts(&self) -> Value {
        let (wheel, zero) = self.wheel.unwrap_or_default();
        json!({
            "name": self.name, "column": self.column, "reading": self.reading, "shift": self.shift, "slope": self.slope.unwrap_or(1.0),
            "function": self.function.map(|own| own.word()), "wheel": wheel, "zero": zero,
        })
    }
}

impl Drawn<'_> {
    fn add(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Adds the line of these genes, of which the last one is drawn. `None`: there are no such genes.
    fn line(&mut self, from: usize, to: usize, is_back: bool, genes: impl Iterator<Item = String>) -> Option<f32> {
        let weights = genes
            .map(|gene| self.genes.remove(&*gene))
            .collect::<Option<Vec<f32>>>()?;
        self.lines
            .push(json!({ "from": from, "to": to, "back": is_back, "weights": weights }));
        weights.last().copied()
    }
}

/// The wheel of an output, and the value at which it stands, by the range of the function.
fn wheel(output: usize, function: Activation) -> (&'static str, f32) {
    let zero = match function {
        Activation::Logistic | Activation::Step => 0.5,
        Activation::Tanh | Activation::Relu | Activation::Linear => 0.0,
    };
    (OUTPUTS[output], zero)
}

/// The gates of an LSTM unit, and what they let in; other units have one sum.
fn sums(kind: LayerKind) -> &'static [&'static str] {
    match kind {
        LayerKind::Lstm => &["_input_gate", "_forget_gate", "_output_gate", "_candidate"],
        _ => &[""],
    }
}

/// A network: its layers, of which the last one has the wheels' units.
struct Layers<'a> {
    controller: &'a Controller,
    all: Vec<Layer>,
    /// The first layer of outputs only, if there is one.
    outputs: usize,
}

impl<'a> Layers<'a> {
    /// `None`: the controller isn't a network of known structure.
    fn of(controller: &'a Controller) -> Option<Self> {
        let dense = |units, activation, slope| Layer {
            units,
            activation,
            slope,
            ..Layer::default()
        };
        let (mut all, outputs) = match controller {
            Controller::Perceptron => (Vec::new(), Some(dense(2, None, None))),
            Controller::Hidden { units } => (vec![dense(*units, None, None)], Some(dense(2, None, None))),
            // Its outputs, which weigh both of the cycle before. No trace has them, but the speeds that they command, from -1 to 1.
            Controller::Recurrent => {
                let outputs = Layer {
                    kind: LayerKind::Elman,
                    ..dense(2, Some(Activation::Tanh), None)
                };
                (Vec::new(), Some(outputs))
            }
            Controller::Network(network) => {
                let is_weighted = network.outputs.unwrap_or_default() == Outputs::Weighted;
                let outputs = is_weighted.then(|| dense(2, network.activation, network.slope));
                (network.layers.clone(), outputs)
            }
            _ => return None,
        };
        let first = all.len();
        all.extend(outputs);
        Some(Self {
            controller,
            all,
            outputs: first,
        })
    }

    /// A unit's name in those of genes.
    fn name(&self, layer: usize, unit: u32) -> String {
        match self.controller {
            _ if layer == self.outputs => OUTPUTS[unit as usize].to_owned(),
            Controller::Hidden { .. } => format!("unit_{unit}"),
            _ => format!("layer_{layer}_unit_{unit}"),
        }
    }

    /// The reading that has what a unit remembers.
    fn reading(&self, layer: usize, unit: u32) -> Option<String> {
        match self.all[layer].kind {
            LayerKind::Dense => None,
            LayerKind::Ctrnn => Some(format!("controller.layer_{layer}_state_{unit}")),
            _ if layer == self.outputs => Some(SPEEDS[unit as usize].to_owned()),
            LayerKind::Elman | LayerKind::Lstm | LayerKind::Plastic => {
                Some(format!("controller.layer_{layer}_unit_{unit}"))
            }
        }
    }
}

fn network(world: &World, genes: &[f32], readings: &[&str], inputs: usize) -> Option<Value> {
    let layers = Layers::of(&world.spec().controller)?;
    let names = world.gene_layout().controller().iter().map(|gene| &*gene.name);
    let mut drawn = Drawn {
        genes: names.zip(genes.iter().copied()).collect(),
        nodes: Vec::new(),
        lines: Vec::new(),
    };
    let mut sources = Vec::new();
    for (reading, name) in readings[..inputs].iter().enumerate() {
        sources.push((drawn.add(Node::new(name, 0, Some(reading))), (*name).to_owned()));
    }
    let bias = drawn.add(Node {
        shift: 1.0,
        ..Node::new("bias", 0, None)
    });
    for (index, layer) in layers.all.iter().enumerate() {
        let kind = layer.kind;
        let range = match kind {
            LayerKind::Dense | LayerKind::Elman => layer.activation.unwrap_or_default(),
            LayerKind::Ctrnn | LayerKind::Plastic => Activation::Logistic,
            LayerKind::Lstm => Activation::Tanh,
        };
        let mut units = Vec::new();
        for unit in 0..layer.units {
            let reading = match layers.reading(index, unit) {
                Some(remembered) => Some(readings.iter().position(|name| *name == remembered)?),
                None => None,
            };
            let name = layers.name(index, unit);
            let is_output = index + 1 == layers.all.len() && unit < 2;
            let wheel = is_output.then(|| wheel(unit as usize, range));
            let shown = match wheel {
                Some((wheel, _)) if wheel != name => format!("{name} ({wheel})"),
                Some(_) if reading.is_some() => format!("{name}, by the wheel's speed"),
                _ => name.clone(),
            };
            let function = [LayerKind::Dense, LayerKind::Ctrnn].contains(&kind).then_some(range);
            let node = Node {
                function,
                slope: layer.slope,
                wheel,
                ..Node::new(&shown, index + 1, reading)
            };
            units.push((drawn.add(node), name));
        }
        for (number, (unit, name)) in units.iter().enumerate() {
            let ended = |from: String| sums(kind).iter().map(move |ending| format!("{from}{ending}"));
            let first = drawn.lines.len();
            for (from, source) in &sources {
                drawn.line(*from, *unit, false, ended(format!("{source}_to_{name}")))?;
            }
            let before = if index == layers.outputs { "previous_" } else { "" };
            for (from, other) in units.iter().filter(|_| kind != LayerKind::Dense) {
                drawn.line(*from, *unit, true, ended(format!("{before}{other}_to_{name}")))?;
            }
            if kind == LayerKind::Plastic {
                let synapses = sources.len() + units.len();
                for (synapse, (_, source)) in sources.iter().chain(&units).enumerate() {
                    let strength = format!("controller.layer_{index}_strength_{}", number * synapses + synapse);
                    let strength = readings.iter().position(|name| *name == strength)?;
                    let rule = rule(drawn.genes.remove(&*format!("rule_{source}_to_{name}"))?);
                    let rate = drawn
                        .genes
                        .remove(&*format!("rate_{source}_to_{name}"))?
                        .clamp(0.0, 1.0);
                    drawn.lines[first + synapse]["learns"] =
                        json!({ "strength": strength, "rule": rule.word(), "rate": rate });
                }
            }
            if layer.biases.unwrap_or(true) {
                let weight = drawn.line(bias, *unit, false, ended(format!("bias_{name}")))?;
                // The state that a continuous-time unit remembers is without it.
                drawn.nodes[*unit].shift = if kind == LayerKind::Ctrnn { weight } else { 0.0 };
            }
            if kind == LayerKind::Ctrnn {
                let [least, greatest] = layer.time_constants.unwrap_or(TIME_CONSTANTS).map(f64::from);
                let share = f64::from(drawn.genes.remove(&*format!("time_constant_{name}"))?.clamp(0.0, 1.0));
                let seconds = significant(least * exponential(share * logarithm(greatest / least)), 3);
                drawn.nodes[*unit].name.extend([", time constant ", &seconds, " s"]);
            }
        }
        sources = units;
    }
    let is_whole = drawn.genes.is_empty();
    let nodes: Vec<Value> = drawn.nodes.iter().map(Node::facts).collect();
    (is_whole && nodes.len() <= NODES).then(|| json!({ "kind": "network", "nodes": nodes, "lines": drawn.lines }))
}

#[cfg(test)]
mod tests;
