//! Genes of controllers, and names of their inputs.

use std::sync::Arc;

/// Number of a Khepera's proximity sensors.
pub const SENSORS: usize = 8;

/// Names of a Khepera's sensors: direction, and degrees from the heading.
pub const SENSOR_NAMES: [&str; SENSORS] = [
    "left_90",
    "left_45",
    "left_10",
    "right_10",
    "right_45",
    "right_90",
    "back_right",
    "back_left",
];

/// Names of the outputs of the cycle before, which the recurrent controller reads after the sensors.
pub(crate) const PREVIOUS: [&str; 2] = ["previous_left", "previous_right"];

/// A gene of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Gene {
    /// The weight of an input to a unit or an output, such as `left_90_to_right`, a bias, such as `bias_right`, or another
    /// number of the controller. A user's controller names its genes, or they are numbered, from `gene_0`.
    pub name: String,
    /// Minimum and maximum value, if it has a range.
    pub range: Option<[f32; 2]>,
    /// The kind of its values.
    pub kind: GeneKind,
    /// It has an effect only if the whole part of this gene, by its index, is one of these, and that gene has one; `None`: always.
    pub only: Option<(usize, &'static [u32])>,
}

/// The kind of a gene's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GeneKind {
    /// Numbers.
    #[default]
    Number,
    /// Whole numbers: a value is the one below it.
    Whole,
    /// Choices without an order, by number: a value is the one below it.
    Choice,
}

impl Gene {
    /// A gene without a range.
    pub(crate) fn new(name: String) -> Self {
        Self::ranged(name, None)
    }

    /// A gene that is a number, always in effect.
    pub(crate) fn ranged(name: String, range: Option<[f32; 2]>) -> Self {
        Self {
            name,
            range,
            kind: GeneKind::Number,
            only: None,
        }
    }
}

/// Genes in the order of a genome: of one controller, or of several, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneLayout {
    all: Arc<[Gene]>,
    controller: Arc<[Gene]>,
}

impl GeneLayout {
    /// Those of one controller.
    pub(crate) fn new(controller: Vec<Gene>) -> Self {
        let controller: Arc<[Gene]> = controller.into();
        Self {
            all: Arc::clone(&controller),
            controller,
        }
    }

    /// Those of as many controllers as there are names, which the genes' names begin with.
    pub(crate) fn several(controller: Vec<Gene>, names: &[String]) -> Self {
        let genes = controller.len();
        let named = |(index, name): (usize, &String)| {
            let genes_of_robot = controller.iter().map(|gene| Gene {
                name: format!("{name}.{}", gene.name),
                only: gene.only.map(|(other, values)| (index * genes + other, values)),
                ..gene.clone()
            });
            genes_of_robot.collect::<Vec<_>>()
        };
        Self {
            all: names.iter().enumerate().flat_map(named).collect(),
            controller: controller.into(),
        }
    }

    /// The other one instead, if it is equal: the names of many genes take megabytes.
    pub(crate) fn or_equal(self, other: Option<&Self>) -> Self {
        other.filter(|other| **other == self).cloned().unwrap_or(self)
    }

    /// The genes.
    pub fn all(&self) -> &[Gene] {
        &self.all
    }

    /// Those of one controller, by their names in it. A genome of robots with one genome each, or with one for each team, has
    /// several such controllers.
    pub fn controller(&self) -> &[Gene] {
        &self.controller
    }

    /// Number of genes.
    pub fn genes(&self) -> usize {
        self.all.len()
    }

    /// Name of each gene.
    pub fn names(&self) -> Vec<String> {
        self.all.iter().map(|gene| gene.name.clone()).collect()
    }

    /// Range of each gene that has one.
    pub fn ranges(&self) -> Vec<Option<[f32; 2]>> {
        self.all.iter().map(|gene| gene.range).collect()
    }
}
