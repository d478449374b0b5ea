//! A network as an ONNX model (onnx.ai, `onnx.proto3`; opset 13), a batch of robots at a time. Its arithmetic is the runtime's, so it hasn't
//! the simulator's bits.

use std::collections::HashMap;

use super::pieces::head;
use super::{Controller, Recorded};
use crate::batch::LEAST_GENE;
use crate::genes::PREVIOUS;
use crate::parameter::{Choice, Invalid};
use crate::parts::network::{Activation, GREATEST_OUTPUT, Layer, LayerKind, Network, Outputs};
use crate::world::Controller as Kind;

/// Prints a network as an ONNX model. The inputs are `readings` and what each layer remembers, the outputs `commands` of both wheels and
/// what it remembers next; the first dimension of all is the robots'.
///
/// # Errors
/// A controller that is no network, or one that learns.
pub fn onnx(controller: &Controller, name: &str, origin: &[String], _cycles: &[Recorded]) -> Result<Vec<u8>, Invalid> {
    let genes = controller.genes.iter().map(|(name, gene)| {
        let is_least = gene.abs() < LEAST_GENE;
        (name.as_str(), if is_least { 0.0 } else { *gene })
    });
    let mut graph = Graph {
        genes: genes.collect(),
        ..Graph::default()
    };
    let inputs: Vec<String> = controller.inputs.iter().map(|input| input.name.clone()).collect();
    graph.declare(INPUT, "readings", inputs.len());
    graph.declare(OUTPUT, "commands", 2);
    let logistic = Network::default();
    match &controller.world.spec().controller {
        Kind::Perceptron => graph.network(&logistic, inputs, "")?,
        Kind::Hidden { units } => {
            let layer = Layer {
                units: *units,
                ..Layer::default()
            };
            let network = Network {
                layers: vec![layer],
                ..logistic
            };
            graph.network(&network, inputs, "")?;
        }
        Kind::Recurrent => {
            graph.declare(INPUT, "previous", 2);
            graph.declare(OUTPUT, "next_previous", 2);
            let both = graph.joined("readings", "previous");
            let inputs = [inputs, PREVIOUS.map(str::to_owned).to_vec()].concat();
            let commands = graph.outputs(&logistic, &both, &inputs);
            graph.named("Identity", &[&commands], "next_previous");
            graph.named("Identity", &[&commands], "commands");
        }
        Kind::Network(network) => graph.network(network, inputs, "layer_N_")?,
        other => {
            let allowed = "perceptron, hidden, recurrent, network";
            let problem = format!("is `{}`; allowed for onnx: {allowed}", other.word());
            return Err(Invalid::new("controller.kind", problem));
        }
    }
    let mut about = head(controller, name, origin);
    about.push("Runtimes round otherwise than the simulator: the outputs have other bits.".to_owned());
    Ok(graph.model(name, &about.join("\n")))
}

/// The field numbers of a graph's inputs and outputs.
const INPUT: u32 = 11;
const OUTPUT: u32 = 12;

/// A graph that grows: its fields, and the names of values that it has made.
#[derive(Default)]
struct Graph<'a> {
    genes: HashMap<&'a str, f32>,
    fields: Message,
    values: usize,
}

impl Graph<'_> {
    /// A network from `readings` to `commands`. Its units are named as its genes name them; `N` in what begins their names is their
    /// layer's place.
    fn network(&mut self, network: &Network, mut inputs: Vec<String>, of_layer: &str) -> Result<(), Invalid> {
        let mut x = "readings".to_owned();
        for (index, layer) in network.layers.iter().enumerate() {
            let place = of_layer.replace('N', &index.to_string());
            let units = (0..layer.units).map(|unit| format!("{place}unit_{unit}")).collect();
            x = self.layer(layer, index, &x, &inputs, &units)?;
            inputs = units;
        }
        let commands = match (network.outputs, network.layers.last()) {
            (Some(Outputs::FirstTwo), Some(layer)) => {
                let [begin, end, axes] = [0, 2, 1].map(|number| self.whole(number));
                let two = self.node("Slice", &[&x, &begin, &end, &axes]);
                self.command(layer.range(), two)
            }
            _ => self.outputs(network, &x, &inputs),
        };
        self.named("Identity", &[&commands], "commands");
        Ok(())
    }

    /// The commands of two units that weigh these inputs.
    fn outputs(&mut self, network: &Network, x: &str, inputs: &[String]) -> String {
        let units = ["left", "right"].map(str::to_owned);
        let sum = self.weighed(x, inputs, &units, "", true);
        let activation = network.activation.unwrap_or_default();
        let outputs = self.activation(activation, network.slope, sum);
        self.command(activation, outputs)
    }

    /// A layer's outputs.
    fn layer(
        &mut self,
        layer: &Layer,
        index: usize,
        x: &str,
        inputs: &[String],
        units: &Vec<String>,
    ) -> Result<String, Invalid> {
        let has_biases = layer.has_biases();
        let sources = [inputs, units].concat();
        match layer.kind {
            LayerKind::Dense => {
                let sum = self.weighed(x, inputs, units, "", has_biases);
                Ok(self.activation(layer.activation.unwrap_or_default(), layer.slope, sum))
            }
            LayerKind::Elman => {
                let before = self.remembered(index, "unit", units.len());
                let all = self.joined(x, &before);
                let sum = self.weighed(&all, &sources, units, "", has_biases);
                let output = self.activation(layer.activation.unwrap_or_default(), layer.slope, sum);
                self.remember(index, "unit", units.len(), &output);
                Ok(output)
            }
            LayerKind::Ctrnn => {
                let state = self.remembered(index, "state", units.len());
                let biases = has_biases.then(|| self.of_units(units, |graph, unit| graph.gene("bias", unit)));
                let rates = self.of_units(units, |graph, unit| layer.rate(graph.gene("time_constant", unit)));
                let output_of = |graph: &mut Self, state: &str| {
                    let sum = biases.as_ref().map(|biases| graph.node("Add", &[state, biases]));
                    graph.node("Sigmoid", &[sum.as_deref().unwrap_or(state)])
                };
                let before = output_of(self, &state);
                let all = self.joined(x, &before);
                let sum = self.weighed(&all, &sources, units, "", false);
                let away = self.node("Sub", &[&sum, &state]);
                let change = self.node("Mul", &[&rates, &away]);
                let next = self.node("Add", &[&state, &change]);
                self.remember(index, "state", units.len(), &next);
                Ok(output_of(self, &next))
            }
            LayerKind::Lstm => {
                let before = self.remembered(index, "unit", units.len());
                let cell = self.remembered(index, "cell", units.len());
                let all = self.joined(x, &before);
                let [input, forget, output, candidate] = ["_input_gate", "_forget_gate", "_output_gate", "_candidate"]
                    .map(|gate| self.weighed(&all, &sources, units, gate, has_biases));
                let one = self.tensor(&[], &[1.0]);
                let forget = self.node("Add", &[&forget, &one]);
                let [input, forget, output] = [input, forget, output].map(|gate| self.node("Sigmoid", &[&gate]));
                let candidate = self.node("Tanh", &[&candidate]);
                let kept = self.node("Mul", &[&forget, &cell]);
                let new = self.node("Mul", &[&input, &candidate]);
                let cell = self.node("Add", &[&kept, &new]);
                let shown = self.node("Tanh", &[&cell]);
                let output = self.node("Mul", &[&output, &shown]);
                self.remember(index, "cell", units.len(), &cell);
                self.remember(index, "unit", units.len(), &output);
                Ok(output)
            }
            LayerKind::Plastic => {
                let problem = "is `plastic`, whose weights change in an episode; allowed for onnx: other kinds";
                Err(Invalid::new(format!("controller.layers[{index}].kind"), problem))
            }
        }
    }

    /// The sums of units: the genes say how much each weighs each source. `ending` is that of a gate's genes.
    fn weighed(&mut self, x: &str, sources: &[String], units: &[String], ending: &str, has_biases: bool) -> String {
        let weight = |unit: &String, source: &String| self.genes[format!("{source}_to_{unit}{ending}").as_str()];
        let weights: Vec<f32> = units
            .iter()
            .flat_map(|unit| sources.iter().map(move |source| weight(unit, source)))
            .collect();
        let weights = self.tensor(&[units.len(), sources.len()], &weights);
        let biases =
            has_biases.then(|| self.of_units(units, |graph, unit| graph.gene("bias", &format!("{unit}{ending}"))));
        let all: Vec<&str> = [x, &weights].into_iter().chain(biases.as_deref()).collect();
        let output = self.value();
        let transposed = Message::default().text(1, "transB").number(3, 1).number(20, 2);
        self.push("Gemm", &all, &output, Some(transposed));
        output
    }

    fn gene(&self, what: &str, unit: &str) -> f32 {
        self.genes[format!("{what}_{unit}").as_str()]
    }

    /// A number for each unit.
    fn of_units(&mut self, units: &[String], number: impl Fn(&Self, &str) -> f32) -> String {
        let numbers: Vec<_> = units.iter().map(|unit| number(self, unit)).collect();
        self.tensor(&[units.len()], &numbers)
    }

    fn activation(&mut self, activation: Activation, slope: Option<f32>, sum: String) -> String {
        let x = match slope {
            Some(slope) => {
                let slope = self.tensor(&[], &[slope]);
                self.node("Mul", &[&sum, &slope])
            }
            None => sum,
        };
        match activation {
            Activation::Logistic => self.node("Sigmoid", &[&x]),
            Activation::Tanh => self.node("Tanh", &[&x]),
            Activation::Relu => self.clipped(&x, 0.0, GREATEST_OUTPUT),
            Activation::Linear => self.clipped(&x, -GREATEST_OUTPUT, GREATEST_OUTPUT),
            Activation::Step => {
                let zero = self.tensor(&[], &[0.0]);
                let is_positive = self.node("Greater", &[&x, &zero]);
                let output = self.value();
                let to_float = Message::default().text(1, "to").number(3, 1).number(20, 2);
                self.push("Cast", &[&is_positive], &output, Some(to_float));
                output
            }
        }
    }

    /// The commands that outputs with this activation's range are.
    fn command(&mut self, activation: Activation, outputs: String) -> String {
        match activation {
            Activation::Logistic | Activation::Step => outputs,
            Activation::Tanh | Activation::Relu | Activation::Linear => {
                let half = self.tensor(&[], &[0.5]);
                let scaled = self.node("Mul", &[&outputs, &half]);
                let command = self.node("Add", &[&scaled, &half]);
                self.clipped(&command, 0.0, 1.0)
            }
        }
    }

    fn clipped(&mut self, x: &str, least: f32, greatest: f32) -> String {
        let [least, greatest] = [least, greatest].map(|end| self.tensor(&[], &[end]));
        self.node("Clip", &[x, &least, &greatest])
    }

    fn joined(&mut self, x: &str, y: &str) -> String {
        let output = self.value();
        let axis = Message::default().text(1, "axis").number(3, 1).number(20, 2);
        self.push("Concat", &[x, y], &output, Some(axis));
        output
    }

    /// What a layer remembers from the cycle before.
    fn remembered(&mut self, layer: usize, what: &str, units: usize) -> String {
        let name = format!("layer_{layer}_{what}");
        self.declare(INPUT, &name, units);
        name
    }

    /// What it remembers for the next cycle.
    fn remember(&mut self, layer: usize, what: &str, units: usize, value: &str) {
        let name = format!("next_layer_{layer}_{what}");
        self.declare(OUTPUT, &name, units);
        self.named("Identity", &[value], &name);
    }

    fn value(&mut self) -> String {
        self.values += 1;
        format!("value_{}", self.values)
    }

    fn node(&mut self, operator: &str, inputs: &[&str]) -> String {
        let output = self.value();
        self.push(operator, inputs, &output, None);
        output
    }

    fn named(&mut self, operator: &str, inputs: &[&str], output: &str) {
        self.push(operator, inputs, output, None);
    }

    fn push(&mut self, operator: &str, inputs: &[&str], output: &str, attribute: Option<Message>) {
        let node = inputs
            .iter()
            .fold(Message::default(), |node, input| node.text(1, input));
        let node = node.text(2, output).text(4, operator);
        let node = attribute
            .iter()
            .fold(node, |node, attribute| node.message(5, attribute));
        self.add(1, &node);
    }

    /// A constant of floats.
    fn tensor(&mut self, shape: &[usize], numbers: &[f32]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.constant(shape, 1, &bytes)
    }

    /// A constant list of one whole number.
    fn whole(&mut self, number: i64) -> String {
        self.constant(&[1], 7, &number.to_le_bytes())
    }

    fn constant(&mut self, shape: &[usize], ty: u64, bytes: &[u8]) -> String {
        let name = self.value();
        let tensor = shape
            .iter()
            .fold(Message::default(), |tensor, size| tensor.number(1, *size as u64));
        self.add(5, &tensor.number(2, ty).text(8, &name).bytes(9, bytes));
        name
    }

    /// Declares an input or an output of so many floats for each robot.
    fn declare(&mut self, field: u32, name: &str, count: usize) {
        let sizes = [
            Message::default().text(2, "robots"),
            Message::default().number(1, count as u64),
        ];
        let shape = sizes
            .iter()
            .fold(Message::default(), |shape, size| shape.message(1, size));
        let ty = Message::default().number(1, 1).message(2, &shape);
        let ty = Message::default().message(1, &ty);
        self.add(field, &Message::default().text(1, name).message(2, &ty));
    }

    fn add(&mut self, field: u32, message: &Message) {
        self.fields = std::mem::take(&mut self.fields).message(field, message);
    }

    fn model(self, name: &str, about: &str) -> Vec<u8> {
        let graph = self.fields.text(2, name);
        let model = Message::default()
            .number(1, 7)
            .text(2, "Oneiro")
            .text(3, env!("CARGO_PKG_VERSION"))
            .text(6, about)
            .message(7, &graph)
            .message(8, &Message::default().text(1, "").number(2, 13));
        model.0
    }
}

/// A message of protocol buffers.
#[derive(Default)]
struct Message(Vec<u8>);

impl Message {
    fn variable(&mut self, mut number: u64) {
        while number >= 128 {
            self.0.push(number as u8 | 128);
            number >>= 7;
        }
        self.0.push(number as u8);
    }

    fn number(mut self, field: u32, number: u64) -> Self {
        self.variable(u64::from(field << 3));
        self.variable(number);
        self
    }

    fn bytes(mut self, field: u32, bytes: &[u8]) -> Self {
        self.variable(u64::from(field << 3 | 2));
        self.variable(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
        self
    }

    fn text(self, field: u32, text: &str) -> Self {
        self.bytes(field, text.as_bytes())
    }

    fn message(self, field: u32, message: &Self) -> Self {
        self.bytes(field, &message.0)
    }
}
