//! Networks given by their layers. Each is written out as the WGSL of a controller, and composed like a user's.

use std::fmt::Write;
use std::iter;

use crate::exact;
use crate::genes::Gene;
use crate::parameter::{Choice, Choices, Invalid, length, only_where};

/// A neural network from all readings to the commands of the two wheels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    /// Layers between readings and outputs, in order.
    pub layers: Vec<Layer>,
    /// Source of the outputs. `None`: weighted.
    pub outputs: Option<Outputs>,
    /// Activation function of weighted outputs. `None`: logistic.
    pub activation: Option<Activation>,
    /// Factor of the sum in that function. `None`: 1.
    pub slope: Option<f32>,
    /// Without layers: whether the genes are in the order of the inputs, for each the weight to the left and to the right output, as
    /// EvoStick has them. `None`: the left output's come first.
    pub interleaved: Option<bool>,
}

/// A layer of units.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The kind of its units.
    pub kind: LayerKind,
    /// Number of units, 1 to [`GREATEST_UNITS`].
    pub units: u32,
    /// Activation function of dense and Elman layers. `None`: logistic.
    pub activation: Option<Activation>,
    /// Factor of the sum in that function. `None`: 1.
    pub slope: Option<f32>,
    /// Whether each unit has a bias. `None`: yes.
    pub biases: Option<bool>,
    /// Minimum and maximum time constant of a continuous-time layer, s. `None`: [`TIME_CONSTANTS`].
    pub time_constants: Option<[f32; 2]>,
    /// Minimum and maximum strength of a plastic layer's synapses when an episode begins. `None`: [`INITIAL_STRENGTHS`].
    pub initial_strengths: Option<[f32; 2]>,
}

impl Default for Layer {
    fn default() -> Self {
        Self {
            kind: LayerKind::Dense,
            units: 4,
            activation: None,
            slope: None,
            biases: None,
            time_constants: None,
            initial_strengths: None,
        }
    }
}

/// A kind of layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerKind {
    /// No memory.
    Dense,
    /// Each unit also weighs all units' outputs of the previous cycle (Elman 1990).
    Elman,
    /// Continuous-time recurrent units, `tau y' = -y + sum`, output `logistic(y + bias)` (Beer 1995), by Euler's method with the
    /// cycle as its step. Each unit also weighs all units' outputs of the previous cycle, and has its time constant as a gene.
    Ctrnn,
    /// Long short-term memory (Hochreiter and Schmidhuber 1997; forget gates by Gers et al. 2000, with 1 added to their sums).
    /// All gates also weigh all units' outputs of the previous cycle.
    Lstm,
    /// Logistic units as Elman's, of which each synapse has a strength from 0 to 1 that changes in each cycle, by one of four
    /// Hebbian rules (Floreano and Urzelai 2000). Its weight is its gene times its strength; two more genes are its rule and its
    /// learning rate.
    Plastic,
}

/// An activation function of a sum `x`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Activation {
    /// `1 / (1 + exp(-x))`.
    #[default]
    Logistic,
    /// The hyperbolic tangent.
    Tanh,
    /// `x`, or 0 if `x` is negative; at most [`GREATEST_OUTPUT`].
    Relu,
    /// `x`, within plus and minus [`GREATEST_OUTPUT`].
    Linear,
    /// 1 if `x` is positive, else 0.
    Step,
}

/// Source of a network's two outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outputs {
    /// Two units that weigh all outputs of the last layer, or all readings if there is no layer.
    #[default]
    Weighted,
    /// The first two units of the last layer.
    FirstTwo,
}

/// Most units of a layer.
pub const GREATEST_UNITS: u32 = 1024;
/// Most synapses of a network that learn: an episode remembers the strength of each.
pub const GREATEST_SYNAPSES: u32 = 1024;
/// Most layers.
pub const GREATEST_LAYERS: usize = 8;
/// Maximum output of a unit that is not bounded by its activation function, so that a gene times an output stays finite.
pub const GREATEST_OUTPUT: f32 = 1000.0;
/// Default range of time constants, s.
pub const TIME_CONSTANTS: [f32; 2] = [0.1, 5.0];

/// Default range of the strengths of synapses when an episode begins (Floreano and Urzelai 2000).
pub const INITIAL_STRENGTHS: [f32; 2] = [0.0, 0.1];

/// A rule by which a synapse's strength `w` changes, from the activity `x` before it and `y` behind it (Floreano and Urzelai 2000).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// `(1 - w) x y`.
    Hebb,
    /// `(1 - w) x y - w (1 - x) y`.
    Postsynaptic,
    /// `(1 - w) x y - w x (1 - y)`.
    Presynaptic,
    /// `(1 - w) c` or, if `c` is negative, `w c`, with `c = tanh(4 (1 - |x - y|) - 2)`.
    Covariance,
}

impl Choice for Rule {
    const CHOICES: Choices<Self> = &[
        ("Hebb's rule", Self::Hebb, "(1 - w) x y"),
        ("the postsynaptic rule", Self::Postsynaptic, "(1 - w) x y - w (1 - x) y"),
        ("the presynaptic rule", Self::Presynaptic, "(1 - w) x y - w x (1 - y)"),
        (
            "the covariance rule",
            Self::Covariance,
            "(1 - w) c, or w c if c is negative; c = tanh(4 (1 - |x - y|) - 2)",
        ),
    ];
}

/// The rule that a gene from 0 to 1 chooses: each has a quarter of the range, in their order.
pub fn rule(gene: f32) -> Rule {
    Rule::CHOICES[(4.0 * gene).clamp(0.0, 3.0) as usize].1
}

/// The change of a strength in a cycle: all rules let it rise towards 1 by `up`, and fall towards 0 by `down`.
const LEARNING: &str = "fn learnt(rule: f32, rate: f32, w: f32, x: f32, y: f32) -> f32 {
    let which = clamp(4.0f * rule, 0.0f, 3.0f);
    var up = flushed(x * y);
    var down = 0.0f;
    if (which >= 3.0f) {
        let covariance = hyperbolic_tangent(4.0f * (1.0f - abs(x - y)) - 2.0f);
        up = max(covariance, 0.0f);
        down = max(-covariance, 0.0f);
    } else if (which >= 2.0f) {
        down = flushed(x * (1.0f - y));
    } else if (which >= 1.0f) {
        down = flushed((1.0f - x) * y);
    }
    let change = flushed(up - w * (up + down));
    return flushed(clamp(w + clamp(rate, 0.0f, 1.0f) * change, 0.0f, 1.0f));
}
";

/// Duration of a cycle, s.
const CYCLE: f64 = 0.1;

impl Choice for LayerKind {
    const CHOICES: Choices<Self> = &[
        ("dense", Self::Dense, "no memory"),
        (
            "elman",
            Self::Elman,
            "each unit also weighs all units' outputs of the previous cycle",
        ),
        (
            "ctrnn",
            Self::Ctrnn,
            "continuous-time recurrent units, each with its time constant as a gene",
        ),
        ("lstm", Self::Lstm, "long short-term memory"),
        (
            "plastic",
            Self::Plastic,
            "synapses that learn within an episode, each by one of four Hebbian rules",
        ),
    ];
}

impl Choice for Activation {
    const CHOICES: Choices<Self> = &[
        ("logistic", Self::Logistic, "1 / (1 + exp(-x))"),
        ("tanh", Self::Tanh, "the hyperbolic tangent"),
        ("relu", Self::Relu, "x, or 0 if x is negative; at most 1000"),
        ("linear", Self::Linear, "x, from -1000 to 1000"),
        ("step", Self::Step, "1 if x is positive, else 0"),
    ];
}

impl Choice for Outputs {
    const CHOICES: Choices<Self> = &[
        (
            "weighted",
            Self::Weighted,
            "two units that weigh all outputs of the last layer, or all readings if there is no layer",
        ),
        ("first_two", Self::FirstTwo, "the first two units of the last layer"),
    ];
}

impl Activation {
    /// Its value, in WGSL. The slope is the name of a value.
    fn of(self, slope: Option<String>, sum: &str) -> String {
        let x = slope.map_or_else(|| sum.to_owned(), |slope| format!("values.{slope} * {sum}"));
        match self {
            Self::Logistic => format!("logistic({x})"),
            Self::Tanh => format!("hyperbolic_tangent({x})"),
            Self::Relu => format!("flushed(clamp({x}, 0.0f, {GREATEST_OUTPUT:?}f))"),
            Self::Linear => format!("flushed(clamp({x}, -{GREATEST_OUTPUT:?}f, {GREATEST_OUTPUT:?}f))"),
            Self::Step => format!("select(0.0f, 1.0f, {x} > 0.0f)"),
        }
    }

    /// The command that an output is, in WGSL: functions from 0 to 1 give the command, and others the speed, from -1 to 1.
    fn command(self, output: &str) -> String {
        match self {
            Self::Logistic | Self::Step => output.to_owned(),
            Self::Tanh | Self::Relu | Self::Linear => format!("0.5f + 0.5f * {output}"),
        }
    }
}

impl Layer {
    /// The activation function that its outputs have the range of.
    pub(crate) fn range(&self) -> Activation {
        match self.kind {
            LayerKind::Dense | LayerKind::Elman => self.activation.unwrap_or_default(),
            LayerKind::Ctrnn | LayerKind::Plastic => Activation::Logistic,
            LayerKind::Lstm => Activation::Tanh,
        }
    }

    /// The sums that a unit makes, by the endings of their genes' names.
    pub(crate) fn sums(&self) -> &'static [&'static str] {
        match self.kind {
            LayerKind::Lstm => &["_input_gate", "_forget_gate", "_output_gate", "_candidate"],
            _ => &[""],
        }
    }

    pub(crate) fn has_biases(&self) -> bool {
        self.biases.unwrap_or(true)
    }

    /// Number of outputs of the previous cycle that each unit weighs.
    fn recurrent(&self) -> u32 {
        if self.kind == LayerKind::Dense { 0 } else { self.units }
    }

    /// Number of genes of a sum.
    fn sum_genes(&self, inputs: u32) -> u32 {
        inputs + self.recurrent() + u32::from(self.has_biases())
    }

    /// Number of genes of a unit.
    fn unit_genes(&self, inputs: u32) -> u32 {
        let others = match self.kind {
            LayerKind::Ctrnn => 1,
            LayerKind::Plastic => 2 * self.synapses(inputs),
            LayerKind::Dense | LayerKind::Elman | LayerKind::Lstm => 0,
        };
        self.sums().len() as u32 * self.sum_genes(inputs) + others
    }

    /// Number of what a unit weighs, without its bias.
    fn synapses(&self, inputs: u32) -> u32 {
        inputs + self.recurrent()
    }

    /// The memory of its units, and how many numbers of each there are: outputs of the previous cycle are `unit`.
    fn memory(&self, inputs: u32) -> Vec<(&'static str, u32)> {
        match self.kind {
            LayerKind::Dense => vec![],
            LayerKind::Elman => vec![("unit", self.units)],
            LayerKind::Ctrnn => vec![("state", self.units)],
            LayerKind::Lstm => vec![("unit", self.units), ("cell", self.units)],
            LayerKind::Plastic => vec![("unit", self.units), ("strength", self.units * self.synapses(inputs))],
        }
    }

    /// Its part of a cycle in WGSL, from its first gene on: `unit_N` and so on are what it remembers, `layer_N` its outputs.
    fn wgsl(&self, index: usize, first: u32, readings: &[String], inputs: u32) -> String {
        let (units, of_unit) = (self.units, self.unit_genes(inputs));
        let output = self.ctrnn_output(index, first, inputs);
        let past = match self.kind {
            LayerKind::Ctrnn => format!(
                "    var unit_{index} = array<f32, {units}>();
    for (var unit = 0u; unit < {units}u; unit++) {{
        unit_{index}[unit] = {output};
    }}
"
            ),
            LayerKind::Plastic => self.synapses_wgsl(index, readings, inputs),
            LayerKind::Dense | LayerKind::Elman | LayerKind::Lstm => String::new(),
        };
        let (sums, unit) = (self.weighed(index, inputs), self.unit(index, inputs, &output));
        format!(
            "    var layer_{index} = array<f32, {units}>();
{past}    for (var unit = 0u; unit < {units}u; unit++) {{
    let first = {first}u + unit * {of_unit}u;
{sums}{unit}    }}
"
        )
    }

    /// The output of a continuous-time unit, from its state.
    fn ctrnn_output(&self, index: usize, first: u32, inputs: u32) -> String {
        if !self.has_biases() {
            return format!("logistic(state_{index}[unit])");
        }
        let (bias, of_unit) = (first + inputs + self.units, self.unit_genes(inputs));
        format!("logistic(state_{index}[unit] + gene(episode, {bias}u + unit * {of_unit}u))")
    }

    /// Declares what comes to the synapses of a plastic layer's unit, `source_N`, and gives them strengths as an episode begins.
    fn synapses_wgsl(&self, index: usize, readings: &[String], inputs: u32) -> String {
        let (synapses, [least, span]) = (self.synapses(inputs), strengths(index));
        let (before, input) = match index.checked_sub(1) {
            None => {
                let readings: Vec<_> = readings.iter().map(|name| format!("readings.{name}")).collect();
                let all = format!("    var given = array<f32, {inputs}>({});\n", readings.join(", "));
                (all, "given".to_owned())
            }
            Some(before) => (String::new(), format!("layer_{before}")),
        };
        format!(
            "{before}    var source_{index} = array<f32, {synapses}>();
    for (var input = 0u; input < {inputs}u; input++) {{
        source_{index}[input] = {input}[input];
    }}
    for (var other = 0u; other < {units}u; other++) {{
        source_{index}[{inputs}u + other] = unit_{index}[other];
    }}
    if (step == 0u) {{
        for (var synapse = 0u; synapse < {all}u; synapse++) {{
            let drawn = random(episode, STREAM_CONTROLLER, {index}u, synapse);
            strength_{index}[synapse] = flushed(values.{least} + values.{span} * drawn.x);
        }}
    }}
",
            units = self.units,
            all = self.units * synapses,
        )
    }

    /// Declares a unit's sums of inputs, of outputs of the previous cycle, and of biases but those of continuous-time units.
    fn weighed(&self, index: usize, inputs: u32) -> String {
        let of_sum = self.sum_genes(inputs);
        let mut text = String::new();
        for (sum, ending) in self.sums().iter().enumerate() {
            let (name, offset) = (format!("sum{ending}"), sum as u32 * of_sum);
            if self.kind == LayerKind::Plastic {
                let _ = writeln!(
                    text,
                    "    var sum = 0.0f;
    for (var source = 0u; source < {synapses}u; source++) {{
        let strength = strength_{index}[unit * {synapses}u + source];
        sum += gene(episode, first + source) * flushed(strength * source_{index}[source]);
    }}",
                    synapses = self.synapses(inputs),
                );
            } else {
                let weighed = weighed(&name, &format!("first + {offset}u"), index, inputs);
                let _ = writeln!(text, "    {weighed}");
            }
            if ![LayerKind::Dense, LayerKind::Plastic].contains(&self.kind) {
                let _ = writeln!(
                    text,
                    "    for (var other = 0u; other < {}u; other++) {{
        {name} += gene(episode, first + {}u + other) * unit_{index}[other];
    }}",
                    self.units,
                    offset + inputs
                );
            }
            if self.has_biases() && self.kind != LayerKind::Ctrnn {
                let _ = writeln!(text, "    {name} += gene(episode, first + {}u);", offset + of_sum - 1);
            }
        }
        text
    }

    /// Writes how a unit computes its output from its sums, and a plastic one its strengths from what it has weighed.
    fn unit(&self, index: usize, inputs: u32, ctrnn_output: &str) -> String {
        let genes = self.unit_genes(inputs);
        match self.kind {
            LayerKind::Dense | LayerKind::Elman => {
                let slope = self.slope.map(|_| slope(index));
                let output = self.activation.unwrap_or_default().of(slope, "sum");
                format!("    layer_{index}[unit] = {output};\n")
            }
            LayerKind::Ctrnn => {
                let [fastest, span] = rates(index);
                let gene = format!("clamp(gene(episode, first + {}u), 0.0f, 1.0f)", genes - 1);
                format!(
                    "    let before_{index} = state_{index}[unit];
    let rate = values.{fastest} * exponential(-values.{span} * {gene});
    state_{index}[unit] = flushed(before_{index} + rate * flushed(sum - before_{index}));
    layer_{index}[unit] = {ctrnn_output};
"
                )
            }
            LayerKind::Lstm => format!(
                "    let kept = logistic(sum_forget_gate + 1.0f) * cell_{index}[unit];
    cell_{index}[unit] = flushed(kept + logistic(sum_input_gate) * hyperbolic_tangent(sum_candidate));
    layer_{index}[unit] = flushed(logistic(sum_output_gate) * hyperbolic_tangent(cell_{index}[unit]));
"
            ),
            LayerKind::Plastic => {
                let output = Activation::Logistic.of(self.slope.map(|_| slope(index)), "sum");
                let (synapses, rules) = (self.synapses(inputs), self.sum_genes(inputs));
                let rates = rules + synapses;
                format!(
                    "    layer_{index}[unit] = {output};
    for (var source = 0u; source < {synapses}u; source++) {{
        let synapse = unit * {synapses}u + source;
        let rule = gene(episode, first + {rules}u + source);
        let rate = gene(episode, first + {rates}u + source);
        let activity = clamp(source_{index}[source], 0.0f, 1.0f);
        strength_{index}[synapse] = learnt(rule, rate, strength_{index}[synapse], activity, layer_{index}[unit]);
    }}
"
                )
            }
        }
    }

    /// Its values, by name: the slope, if it has one, and of time constants the maximum fraction of one that a cycle is, and the
    /// logarithm of the maximum by the minimum. A time constant is `minimum (maximum / minimum)^gene` for a gene from 0 to 1.
    fn values(&self, index: usize) -> Vec<(String, f32)> {
        let slope_value = self.slope.map(|factor| (slope(index), factor)).into_iter();
        let (names, numbers) = match self.kind {
            LayerKind::Ctrnn => {
                let [least, greatest] = self.time_constants.unwrap_or(TIME_CONSTANTS).map(f64::from);
                (rates(index), [CYCLE / least, exact::logarithm(greatest / least)])
            }
            LayerKind::Plastic => {
                let [least, greatest] = self.initial_strengths.unwrap_or(INITIAL_STRENGTHS).map(f64::from);
                (strengths(index), [least, greatest - least])
            }
            LayerKind::Dense | LayerKind::Elman | LayerKind::Lstm => return slope_value.collect(),
        };
        let numbers = numbers.map(|number| number as f32);
        slope_value.chain(names.into_iter().zip(numbers)).collect()
    }

    /// Of a continuous-time layer: from the gene of a unit's time constant to the fraction of it that a cycle is.
    #[cfg(feature = "compose")]
    pub(crate) fn rate(&self, gene: f32) -> f32 {
        let [least, greatest] = self.time_constants.unwrap_or(TIME_CONSTANTS).map(f64::from);
        let lasts = f64::from(gene).clamp(0.0, 1.0) * exact::logarithm(greatest / least);
        (CYCLE / least * exact::exponential(-lasts)) as f32
    }

    /// Checks conditions that involve several of its values; errors have keys without the layer's place.
    fn check(&self) -> Result<(), Invalid> {
        let has_activation = matches!(self.kind, LayerKind::Dense | LayerKind::Elman);
        let has_slope = has_activation || self.kind == LayerKind::Plastic;
        only_where(
            format_args!("kind = \"{}\"", self.kind.word()),
            &[
                ("activation", self.activation.is_some(), has_activation),
                ("slope", self.slope.is_some(), has_slope),
                (
                    "time_constants_s",
                    self.time_constants.is_some(),
                    self.kind == LayerKind::Ctrnn,
                ),
                (
                    "initial_strengths",
                    self.initial_strengths.is_some(),
                    self.kind == LayerKind::Plastic,
                ),
            ],
        )?;
        for (key, range) in [
            ("time_constants_s", self.time_constants),
            ("initial_strengths", self.initial_strengths),
        ] {
            if let Some([least, greatest]) = range.filter(|[least, greatest]| least > greatest) {
                let problem = format!("is [{least}, {greatest}]; allowed: [minimum, maximum]");
                return Err(Invalid::new(key, problem));
            }
        }
        Ok(())
    }
}

/// The name of a layer's slope among the values; that of weighted outputs follows those of the layers.
fn slope(layer: usize) -> String {
    format!("slope_{layer}")
}

/// The names of what a layer's time constants are made of, among the values.
fn rates(layer: usize) -> [String; 2] {
    [format!("fastest_{layer}"), format!("span_{layer}")]
}

/// The names of the minimum and the range of a layer's initial strengths, among the values.
fn strengths(layer: usize) -> [String; 2] {
    [format!("weakest_{layer}"), format!("strengths_{layer}")]
}

impl Network {
    /// Genes for these readings: of each unit, layer by layer, the weights of its inputs, of the outputs of the previous
    /// cycle, and its bias; of an LSTM unit for each gate; of a continuous-time unit also its time constant, and of a plastic one
    /// the rule and the learning rate of each synapse. Then those of weighted outputs.
    pub(crate) fn genes(&self, readings: &[String]) -> Vec<Gene> {
        let mut genes = Vec::new();
        let mut inputs = readings.to_vec();
        for (index, layer) in self.layers.iter().enumerate() {
            let units: Vec<String> = (0..layer.units)
                .map(|unit| format!("layer_{index}_unit_{unit}"))
                .collect();
            for unit in &units {
                for sum in layer.sums() {
                    let recurrent = &units[..layer.recurrent() as usize];
                    let weights = inputs.iter().chain(recurrent);
                    genes.extend(weights.map(|input| Gene::new(format!("{input}_to_{unit}{sum}"))));
                    genes.extend(layer.has_biases().then(|| Gene::new(format!("bias_{unit}{sum}"))));
                }
                let within = |name: String| Gene::ranged(name, Some([0.0, 1.0]));
                match layer.kind {
                    LayerKind::Ctrnn => genes.push(within(format!("time_constant_{unit}"))),
                    LayerKind::Plastic => {
                        for what in ["rule", "rate"] {
                            let sources = inputs.iter().chain(&units);
                            genes.extend(sources.map(|source| within(format!("{what}_{source}_to_{unit}"))));
                        }
                    }
                    LayerKind::Dense | LayerKind::Elman | LayerKind::Lstm => {}
                }
            }
            inputs = units;
        }
        if self.is_interleaved() {
            let to = |input: String| ["left", "right"].map(|output| Gene::new(format!("{input}_{output}")));
            let weights = inputs.into_iter().map(|input| format!("{input}_to"));
            genes.extend(weights.chain(["bias".to_owned()]).flat_map(to));
        } else if self.outputs.unwrap_or_default() == Outputs::Weighted {
            for output in ["left", "right"] {
                genes.extend(inputs.iter().map(|input| Gene::new(format!("{input}_to_{output}"))));
                genes.push(Gene::new(format!("bias_{output}")));
            }
        }
        genes
    }

    /// Whether the genes are in the order of the inputs.
    fn is_interleaved(&self) -> bool {
        self.interleaved == Some(true)
    }

    /// Writes the network out as the WGSL of a controller. `readings` are its inputs, as fields of `Readings`.
    pub(crate) fn wgsl(&self, readings: &[String]) -> String {
        let (mut fields, mut cycle, mut kept) = (String::new(), String::new(), Vec::new());
        let (mut first, mut inputs) = (0, readings.len() as u32);
        for (index, layer) in self.layers.iter().enumerate() {
            for (what, count) in layer.memory(inputs) {
                let names: Vec<_> = (0..count)
                    .map(|number| format!("layer_{index}_{what}_{number}"))
                    .collect();
                let _ = writeln!(fields, "    {}: f32,", names.join(": f32,\n    "));
                let before: Vec<_> = names.iter().map(|name| format!("before.{name}")).collect();
                let before = before.join(", ");
                let _ = writeln!(cycle, "    var {what}_{index} = array<f32, {count}>({before});");
                let array = if what == "unit" { "layer" } else { what };
                kept.extend((0..count).map(|number| format!("{array}_{index}[{number}]")));
            }
            cycle += &layer.wgsl(index, first, readings, inputs);
            first += layer.units * layer.unit_genes(inputs);
            inputs = layer.units;
        }
        let outputs = match (self.outputs.unwrap_or_default(), self.layers.last()) {
            (Outputs::FirstTwo, Some(layer)) => {
                let last = self.layers.len() - 1;
                [0, 1].map(|unit| layer.range().command(&format!("layer_{last}[{unit}]")))
            }
            _ => ["left", "right"].map(|name| {
                if self.is_interleaved() {
                    let mut gene = u32::from(name == "right");
                    let _ = writeln!(cycle, "    var {name} = 0.0f;");
                    for input in readings {
                        let _ = writeln!(cycle, "    {name} += gene(episode, {gene}u) * readings.{input};");
                        gene += 2;
                    }
                    let _ = writeln!(cycle, "    {name} += gene(episode, {gene}u);");
                } else {
                    let sum = weighed(name, &format!("{first}u"), self.layers.len(), inputs);
                    let _ = writeln!(cycle, "    {sum}\n    {name} += gene(episode, {}u);", first + inputs);
                }
                first += inputs + 1;
                let activation = self.activation.unwrap_or_default();
                let slope = self.slope.map(|_| slope(self.layers.len()));
                activation.command(&activation.of(slope, name))
            }),
        };
        let [left, right] = outputs;
        let (state, after) = if fields.is_empty() {
            (String::new(), "before".to_owned())
        } else {
            let after = format!("ControllerState({})", kept.join(", "));
            (format!("struct ControllerState {{\n{fields}}}\n"), after)
        };
        let (values, reading) = self.declared();
        let learns = self.layers.iter().any(|layer| layer.kind == LayerKind::Plastic);
        let learning = if learns { LEARNING } else { "" };
        format!(
            "const CONTROLLER_GENES: u32 = {first}u;
{values}{state}{learning}fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {{
{reading}{cycle}    return Command(vec2<f32>({left}, {right}), {after});
}}
"
        )
    }

    /// The values that its WGSL declares, in order, so that networks that differ in them share a kernel.
    pub(crate) fn values(&self) -> Vec<(String, f32)> {
        let layers = self.layers.iter().enumerate();
        let of_layers = layers.flat_map(|(index, layer)| layer.values(index));
        let outputs = self.slope.map(|factor| (slope(self.layers.len()), factor));
        of_layers.chain(outputs).collect()
    }

    /// The struct of its values and the statement that reads them, in WGSL.
    fn declared(&self) -> (String, &'static str) {
        let field = |(name, _): (String, f32)| format!("    {name}: f32, // 1, 0 to 1000: of the network\n");
        let fields: String = self.values().into_iter().map(field).collect();
        if fields.is_empty() {
            return (fields, "");
        }
        let reading = "    let values = controller_values(episode);\n";
        (format!("struct ControllerValues {{\n{fields}}}\n"), reading)
    }

    /// Number of synapses that learn, for so many readings.
    fn synapses(&self, readings: u32) -> u32 {
        let inputs = iter::once(readings).chain(self.layers.iter().map(|layer| layer.units));
        let layers = self.layers.iter().zip(inputs);
        let learning = layers.filter(|(layer, _)| layer.kind == LayerKind::Plastic);
        learning
            .map(|(layer, inputs)| layer.units * layer.synapses(inputs))
            .sum()
    }

    /// Checks conditions that involve several values.
    pub(crate) fn check(&self, readings: &[String], greatest_genes: u32) -> Result<(), Invalid> {
        length("controller.layers", self.layers.len(), GREATEST_LAYERS)?;
        for (index, layer) in self.layers.iter().enumerate() {
            let place = format!("controller.layers[{index}]");
            layer.check().map_err(|invalid| invalid.within(&place))?;
        }
        let synapses: u32 = self.synapses(readings.len() as u32);
        if synapses > GREATEST_SYNAPSES {
            let problem = format!("have {synapses} synapses that learn; allowed: up to {GREATEST_SYNAPSES}");
            return Err(Invalid::new("controller.layers", problem));
        }
        if self.is_interleaved() && (!self.layers.is_empty() || self.outputs == Some(Outputs::FirstTwo)) {
            let problem = "is true; allowed: only without layers";
            return Err(Invalid::new("controller.interleaved", problem));
        }
        if self.outputs == Some(Outputs::FirstTwo) {
            if self.layers.last().is_none_or(|layer| layer.units < 2) {
                let problem = "is `first_two`, but the last layer has fewer than two units; allowed: `weighted`";
                return Err(Invalid::new("controller.outputs", problem));
            }
            let checked = only_where(
                "outputs = \"first_two\"",
                &[
                    ("activation", self.activation.is_some(), false),
                    ("slope", self.slope.is_some(), false),
                ],
            );
            checked.map_err(|invalid| invalid.within("controller"))?;
        }
        let genes = self.genes(readings).len();
        if !(1..=greatest_genes as usize).contains(&genes) {
            let problem = format!("make {genes} genes; allowed: 1 to {greatest_genes}");
            return Err(Invalid::new("controller.layers", problem));
        }
        Ok(())
    }
}

/// Declares the sum of all inputs of a layer, each times its gene; `first` is the index of the first of those genes.
fn weighed(name: &str, first: &str, layer: usize, inputs: u32) -> String {
    match layer.checked_sub(1) {
        None => format!("var {name} = weighed(episode, {first}, readings);"),
        Some(before) => format!(
            "var {name} = 0.0f;
    for (var input = 0u; input < {inputs}u; input++) {{
        {name} += gene(episode, {first} + input) * layer_{before}[input];
    }}"
        ),
    }
}
