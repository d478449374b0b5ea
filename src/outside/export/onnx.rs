//! A network as an ONNX model (onnx.ai, `onnx.proto3`; opset 13), a batch of robots at a time. Its arithmetic is the runtime's, so it hasn't
//! the simulator's bits.

use super::pieces::head;
use super::plan::{Planned, Weights, plan};
use super::{Controller, Fitted, Recorded};
use crate::parameter::{Choice, Invalid};
use crate::parts::network::{Activation, GREATEST_OUTPUT, LayerKind};

/// Prints a network as an ONNX model. The inputs are `readings` and what each layer remembers, the outputs `commands` of both wheels and
/// the memory for the next cycle. Each has a row for each robot.
///
/// # Errors
/// A controller that is no network.
pub fn onnx(controller: &Controller, name: &str, origin: &[String], _cycles: &[Recorded]) -> Result<Fitted, Invalid> {
    let all: Vec<LayerKind> = LayerKind::CHOICES.iter().map(|(_, kind, _)| *kind).collect();
    let plan = plan(controller, "onnx", &all)?;
    let mut graph = Graph::default();
    graph.declare(INPUT, "readings", controller.inputs.len());
    graph.declare(OUTPUT, "commands", 2);
    let mut x = "readings".to_owned();
    for (index, layer) in plan.layers.iter().enumerate() {
        x = graph.layer(layer, index, &x);
    }
    if plan.layers.last().is_none_or(|layer| layer.units != 2) {
        let [begin, end, axes] = [0, 2, 1].map(|number| graph.whole(number));
        x = graph.node("Slice", &[&x, &begin, &end, &axes]);
    }
    let commands = graph.command(plan.range, x);
    graph.named("Identity", &[&commands], "commands");
    let mut about = head(controller, name, origin);
    let note = "runtimes round otherwise than the simulator, so its outputs have other bits";
    about.extend([String::new(), note.to_owned()]);
    let drawn = plan.layers.iter().zip(0..);
    about.extend(drawn.filter_map(|(layer, index)| {
        let [least, greatest] = layer.initial_strengths?;
        Some(format!(
            "layer_{index}_strength begins with random numbers from {least} to {greatest}, all other memory with 0"
        ))
    }));
    Ok(Fitted {
        bytes: graph.model(name, &about.join("\n")),
        note: Some(note.to_owned()),
    })
}

/// The field numbers of a graph's inputs and outputs.
const INPUT: u32 = 11;
const OUTPUT: u32 = 12;

/// A graph that grows: its fields, and how many values it has made.
#[derive(Default)]
struct Graph {
    fields: Message,
    values: usize,
}

impl Graph {
    /// A layer's outputs.
    fn layer(&mut self, layer: &Planned, index: usize, x: &str) -> String {
        let units = layer.units;
        match layer.kind {
            LayerKind::Dense => {
                let sum = self.weighed(x, &layer.sums[0], true);
                self.activation(layer, sum)
            }
            LayerKind::Elman => {
                let before = self.remembered(index, "unit", units);
                let all = self.joined(x, &before);
                let sum = self.weighed(&all, &layer.sums[0], true);
                let output = self.activation(layer, sum);
                self.remember(index, "unit", units, &output);
                output
            }
            LayerKind::Ctrnn => {
                let state = self.remembered(index, "state", units);
                let biases = layer.sums[0]
                    .biases
                    .as_ref()
                    .map(|biases| self.tensor(&[units], biases));
                let rates = self.tensor(&[units], &layer.rates);
                let output_of = |graph: &mut Self, state: &str| {
                    let sum = biases.as_ref().map(|biases| graph.node("Add", &[state, biases]));
                    graph.node("Sigmoid", &[sum.as_deref().unwrap_or(state)])
                };
                let before = output_of(self, &state);
                let all = self.joined(x, &before);
                let sum = self.weighed(&all, &layer.sums[0], false);
                let away = self.node("Sub", &[&sum, &state]);
                let change = self.node("Mul", &[&rates, &away]);
                let next = self.node("Add", &[&state, &change]);
                self.remember(index, "state", units, &next);
                output_of(self, &next)
            }
            LayerKind::Lstm => {
                let before = self.remembered(index, "unit", units);
                let cell = self.remembered(index, "cell", units);
                let all = self.joined(x, &before);
                let [input, forget, output, candidate] =
                    [0, 1, 2, 3].map(|gate| self.weighed(&all, &layer.sums[gate], true));
                let one = self.tensor(&[], &[1.0]);
                let forget = self.node("Add", &[&forget, &one]);
                let [input, forget, output] = [input, forget, output].map(|gate| self.node("Sigmoid", &[&gate]));
                let candidate = self.node("Tanh", &[&candidate]);
                let kept = self.node("Mul", &[&forget, &cell]);
                let new = self.node("Mul", &[&input, &candidate]);
                let cell = self.node("Add", &[&kept, &new]);
                let shown = self.node("Tanh", &[&cell]);
                let output = self.node("Mul", &[&output, &shown]);
                self.remember(index, "unit", units, &output);
                self.remember(index, "cell", units, &cell);
                output
            }
            LayerKind::Plastic => self.plastic(layer, index, x),
        }
    }

    /// A layer whose synapses learn: their strengths have a number for each unit and each that it weighs.
    fn plastic(&mut self, layer: &Planned, index: usize, x: &str) -> String {
        let (units, synapses) = (layer.units, layer.sums[0].rows[0].len());
        let [of_all, of_sources, of_units] =
            [[units, synapses], [1, synapses], [units, 1]].map(|shape| self.shape(&shape));
        let before = self.remembered(index, "unit", units);
        let strengths = self.remembered(index, "strength", units * synapses);
        let w = self.node("Reshape", &[&strengths, &of_all]);
        let sources = self.joined(x, &before);
        let source = self.node("Reshape", &[&sources, &of_sources]);
        // The sums.
        let weights = self.tensor(&[units, synapses], &layer.sums[0].rows.concat());
        let strong = self.node("Mul", &[&w, &source]);
        let each = self.node("Mul", &[&weights, &strong]);
        let last = self.whole(2);
        let mut sum = self.value();
        let without = Message::default().text(1, "keepdims").number(3, 0).number(20, 2);
        self.push("ReduceSum", &[&each, &last], &sum, Some(&without));
        if let Some(biases) = &layer.sums[0].biases {
            let biases = self.tensor(&[units], biases);
            sum = self.node("Add", &[&sum, &biases]);
        }
        let output = self.activation(layer, sum);
        self.remember(index, "unit", units, &output);
        // What is learnt.
        let [rules, rates] = &layer.learning;
        let mask = |graph: &mut Self, own: f32| {
            let is_own = rules
                .iter()
                .flatten()
                .map(|rule| (4.0 * rule).clamp(0.0, 3.0).floor() == own);
            graph.tensor(
                &[units, synapses],
                &is_own.map(|own| f32::from(u8::from(own))).collect::<Vec<_>>(),
            )
        };
        let [is_post, is_pre, is_covariance] = [1.0, 2.0, 3.0].map(|own| mask(self, own));
        let rates: Vec<f32> = rates.iter().flatten().map(|rate| rate.clamp(0.0, 1.0)).collect();
        let rates = self.tensor(&[units, synapses], &rates);
        let [zero, one, two, four] = [0.0, 1.0, 2.0, 4.0].map(|number| self.tensor(&[], &[number]));
        let x = self.clipped(&source, 0.0, 1.0);
        let y = self.node("Reshape", &[&output, &of_units]);
        let both = self.node("Mul", &[&x, &y]);
        let [not_x, not_y] = [&x, &y].map(|number| self.node("Sub", &[&one, number]));
        let apart = self.node("Sub", &[&x, &y]);
        let apart = self.node("Abs", &[&apart]);
        let near = self.node("Sub", &[&one, &apart]);
        let near = self.node("Mul", &[&four, &near]);
        let near = self.node("Sub", &[&near, &two]);
        let covariance = self.node("Tanh", &[&near]);
        let rising = self.node("Max", &[&covariance, &zero]);
        let falling = self.node("Sub", &[&rising, &covariance]);
        let more = self.node("Sub", &[&rising, &both]);
        let of_covariance = self.node("Mul", &[&is_covariance, &more]);
        let up = self.node("Add", &[&both, &of_covariance]);
        let downs = [
            (&not_x, &y, &is_post),
            (&x, &not_y, &is_pre),
            (&falling, &one, &is_covariance),
        ];
        let mut down = zero;
        for (left, right, is_own) in downs {
            let own = self.node("Mul", &[left, right]);
            let own = self.node("Mul", &[&own, is_own]);
            down = self.node("Add", &[&down, &own]);
        }
        let lost = self.node("Add", &[&up, &down]);
        let lost = self.node("Mul", &[&w, &lost]);
        let change = self.node("Sub", &[&up, &lost]);
        let change = self.node("Mul", &[&rates, &change]);
        let next = self.node("Add", &[&w, &change]);
        let next = self.clipped(&next, 0.0, 1.0);
        let flat = self.shape(&[units * synapses]);
        let next = self.node("Reshape", &[&next, &flat]);
        self.remember(index, "strength", units * synapses, &next);
        output
    }

    /// The sums of units.
    fn weighed(&mut self, x: &str, weights: &Weights, has_biases: bool) -> String {
        let shape = [weights.rows.len(), weights.rows[0].len()];
        let rows = self.tensor(&shape, &weights.rows.concat());
        let biases = weights.biases.as_ref().filter(|_| has_biases);
        let biases = biases.map(|biases| self.tensor(&shape[..1], biases));
        let all: Vec<&str> = [x, &rows].into_iter().chain(biases.as_deref()).collect();
        let output = self.value();
        let transposed = Message::default().text(1, "transB").number(3, 1).number(20, 2);
        self.push("Gemm", &all, &output, Some(&transposed));
        output
    }

    fn activation(&mut self, layer: &Planned, sum: String) -> String {
        let x = match layer.slope {
            Some(slope) => {
                let slope = self.tensor(&[], &[slope]);
                self.node("Mul", &[&sum, &slope])
            }
            None => sum,
        };
        match layer.activation {
            Activation::Logistic => self.node("Sigmoid", &[&x]),
            Activation::Tanh => self.node("Tanh", &[&x]),
            Activation::Relu => self.clipped(&x, 0.0, GREATEST_OUTPUT),
            Activation::Linear => self.clipped(&x, -GREATEST_OUTPUT, GREATEST_OUTPUT),
            Activation::Step => {
                let zero = self.tensor(&[], &[0.0]);
                let is_positive = self.node("Greater", &[&x, &zero]);
                let output = self.value();
                let to_float = Message::default().text(1, "to").number(3, 1).number(20, 2);
                self.push("Cast", &[&is_positive], &output, Some(&to_float));
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
        self.push("Concat", &[x, y], &output, Some(&axis));
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

    fn push(&mut self, operator: &str, inputs: &[&str], output: &str, attribute: Option<&Message>) {
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

    /// A constant shape of robots with so many numbers each.
    fn shape(&mut self, each: &[usize]) -> String {
        let sizes = [-1].into_iter().chain(each.iter().map(|size| *size as i64));
        let bytes: Vec<u8> = sizes.flat_map(i64::to_le_bytes).collect();
        self.constant(&[each.len() + 1], 7, &bytes)
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
