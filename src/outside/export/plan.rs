//! A controller that is a network, as weights: for what computes it in another way than its kernel.

use std::collections::HashMap;

use super::Controller;
use crate::batch::LEAST_GENE;
use crate::genes::PREVIOUS;
use crate::parameter::{Choice, Invalid};
use crate::parts::network::{Activation, INITIAL_STRENGTHS, Layer, LayerKind, Network, Outputs};
use crate::world::Controller as Kind;

/// A network.
pub(super) struct Plan {
    /// Its layers. The first two units of the last one command the wheels.
    pub(super) layers: Vec<Planned>,
    /// The activation function that has the range of these two.
    pub(super) range: Activation,
}

/// A layer.
pub(super) struct Planned {
    pub(super) kind: LayerKind,
    pub(super) units: usize,
    /// The sums of each unit: one, or those of an LSTM unit's gates in the order of its genes.
    pub(super) sums: Vec<Weights>,
    pub(super) activation: Activation,
    pub(super) slope: Option<f32>,
    /// Of a continuous-time unit: the fraction of its time constant that a cycle is.
    pub(super) rates: Vec<f32>,
    /// Of a unit that learns: for each that it weighs the rule's gene and the learning rate.
    pub(super) learning: [Vec<Vec<f32>>; 2],
    /// Between which numbers the strengths of such a unit's synapses are drawn when an episode begins.
    pub(super) initial_strengths: Option<[f32; 2]>,
}

/// Weights of the sums of a layer's units.
pub(super) struct Weights {
    /// For each unit those of the inputs, then of the layer's own outputs of the previous cycle.
    pub(super) rows: Vec<Vec<f32>>,
    /// None of them has a bias, or each.
    pub(super) biases: Option<Vec<f32>>,
}

/// The network of a controller, for a target of which only some layers can be made.
pub(super) fn plan(controller: &Controller, target: &str, can_be: &[LayerKind]) -> Result<Plan, Invalid> {
    let genes = controller.genes.iter().map(|(name, gene)| {
        let is_least = gene.abs() < LEAST_GENE;
        (name.as_str(), if is_least { 0.0 } else { *gene })
    });
    let genes = Genes(genes.collect());
    let inputs: Vec<String> = controller.inputs.iter().map(|input| input.name.clone()).collect();
    let logistic = |layers| Network {
        layers,
        ..Network::default()
    };
    let (network, of_layer) = match &controller.world.spec().controller {
        Kind::Perceptron => (logistic(vec![]), ""),
        Kind::Hidden { units } => {
            let units = Layer {
                units: *units,
                ..Layer::default()
            };
            (logistic(vec![units]), "")
        }
        Kind::Network(network) => (network.clone(), "layer_N_"),
        Kind::Recurrent => {
            let outputs = genes.outputs(
                &Network::default(),
                &[inputs, PREVIOUS.map(str::to_owned).to_vec()].concat(),
            );
            let layer = Planned {
                kind: LayerKind::Elman,
                ..outputs
            };
            return Ok(Plan {
                layers: vec![layer],
                range: Activation::Logistic,
            });
        }
        other => {
            let problem = format!(
                "is `{}`; allowed for {target}: perceptron, hidden, recurrent, network",
                other.word()
            );
            return Err(Invalid::new("controller.kind", problem));
        }
    };
    let mut sources = inputs;
    let mut layers = Vec::new();
    for (index, layer) in network.layers.iter().enumerate() {
        if !can_be.contains(&layer.kind) {
            let allowed: Vec<_> = can_be.iter().map(Choice::word).collect();
            let problem = format!(
                "is `{}`; allowed for {target}: {}",
                layer.kind.word(),
                allowed.join(", ")
            );
            return Err(Invalid::new(format!("controller.layers[{index}].kind"), problem));
        }
        let place = of_layer.replace('N', &index.to_string());
        let units: Vec<_> = (0..layer.units).map(|unit| format!("{place}unit_{unit}")).collect();
        layers.push(genes.layer(layer, &sources, &units));
        sources = units;
    }
    let range = if let (Some(Outputs::FirstTwo), Some(layer)) = (network.outputs, network.layers.last()) {
        layer.range()
    } else {
        layers.push(genes.outputs(&network, &sources));
        network.activation.unwrap_or_default()
    };
    Ok(Plan { layers, range })
}

/// Genes by their names.
struct Genes<'a>(HashMap<&'a str, f32>);

impl Genes<'_> {
    fn layer(&self, layer: &Layer, inputs: &[String], units: &[String]) -> Planned {
        let own = if layer.kind == LayerKind::Dense { &[][..] } else { units };
        let sources = [inputs, own].concat();
        let rates = units
            .iter()
            .map(|unit| layer.rate(self.0[format!("time_constant_{unit}").as_str()]));
        Planned {
            kind: layer.kind,
            units: units.len(),
            sums: layer
                .sums()
                .iter()
                .map(|gate| self.weights(&sources, units, gate, layer.has_biases()))
                .collect(),
            activation: layer.range(),
            slope: layer.slope,
            rates: if layer.kind == LayerKind::Ctrnn {
                rates.collect()
            } else {
                Vec::new()
            },
            learning: if layer.kind == LayerKind::Plastic {
                ["rule_", "rate_"].map(|what| self.rows(what, &sources, units, ""))
            } else {
                Default::default()
            },
            initial_strengths: (layer.kind == LayerKind::Plastic)
                .then(|| layer.initial_strengths.unwrap_or(INITIAL_STRENGTHS)),
        }
    }

    /// The two units that weigh the last layer's outputs, or all readings.
    fn outputs(&self, network: &Network, inputs: &[String]) -> Planned {
        let units = ["left", "right"].map(str::to_owned);
        Planned {
            kind: LayerKind::Dense,
            units: 2,
            sums: vec![self.weights(inputs, &units, "", true)],
            activation: network.activation.unwrap_or_default(),
            slope: network.slope,
            rates: Vec::new(),
            learning: Default::default(),
            initial_strengths: None,
        }
    }

    /// A gene of each unit for each of its sources, whose name begins with `what`.
    fn rows(&self, what: &str, sources: &[String], units: &[String], gate: &str) -> Vec<Vec<f32>> {
        let row = |unit: &String| {
            let genes = sources
                .iter()
                .map(|source| self.0[format!("{what}{source}_to_{unit}{gate}").as_str()]);
            genes.collect()
        };
        units.iter().map(row).collect()
    }

    /// `gate` ends the names of a gate's genes.
    fn weights(&self, sources: &[String], units: &[String], gate: &str, has_biases: bool) -> Weights {
        let biases = units.iter().map(|unit| self.0[format!("bias_{unit}{gate}").as_str()]);
        Weights {
            rows: self.rows("", sources, units, gate),
            biases: has_biases.then(|| biases.collect()),
        }
    }
}
