//! Measures of behaviour, by which `map-elites` and `novelty` describe individuals.

use oneiro::parameter::Allowed::{Any, Text, Whole};
use oneiro::parameter::{Parameter, row};
use serde::Serialize;

use super::{Checked, Feature, Settings, refused};

const OURS: &str = "ours";

/// A measure of behaviour that an optimiser uses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Descriptor {
    /// Its name.
    pub measure: String,
    /// Its range; NaN until it is given.
    pub least: f32,
    pub greatest: f32,
    /// Cells that a grid divides the range into.
    pub cells: u32,
}

impl Default for Descriptor {
    fn default() -> Self {
        Self {
            measure: String::new(),
            least: f32::NAN,
            greatest: f32::NAN,
            cells: 20,
        }
    }
}

impl Descriptor {
    /// A value as a fraction of the range.
    pub fn share(&self, value: f64) -> f64 {
        let [least, greatest] = [self.least, self.greatest].map(f64::from);
        (value - least) / (greatest - least)
    }

    #[cfg(test)]
    pub(crate) fn named(measure: &str, [least, greatest]: [f32; 2], cells: u32) -> Self {
        Self {
            measure: measure.into(),
            least,
            greatest,
            cells,
        }
    }
}

impl Settings {
    /// With an optimiser that uses behaviour.
    fn if_uses_behaviour(&mut self) -> Option<&mut Self> {
        self.is(Feature::Behaviour).then_some(self)
    }
}

/// Rows of these values.
#[rustfmt::skip]
pub(crate) fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
    vec![
        row("evolution.descriptors", "", Any, OURS,
            "Measures that describe behaviour: 1 to 6.", |values, _| Some(&mut values.as_mut().if_uses_behaviour()?.descriptors)),
        row("evolution.descriptors[].measure", "", Text("a measure of docs/measures.md"), "",
            "Name of a measure; its mean over several episodes counts.", |values, index| Some(&mut values.as_mut().if_uses_behaviour()?.descriptors.get_mut(index)?.measure)),
        row("evolution.descriptors[].least", "", Any, "",
            "The minimum of its range, in the measure's unit; values outside count as the nearest end.", |values, index| Some(&mut values.as_mut().if_uses_behaviour()?.descriptors.get_mut(index)?.least)),
        row("evolution.descriptors[].greatest", "", Any, "",
            "The maximum.", |values, index| Some(&mut values.as_mut().if_uses_behaviour()?.descriptors.get_mut(index)?.greatest)),
        row("evolution.descriptors[].cells", "", Whole(1, 100_000), "",
            "Cells that a grid divides the range into.", |values, index| Some(&mut values.as_mut().if_uses_behaviour()?.descriptors.get_mut(index)?.cells)),
    ]
}

/// Checks their number, ranges and names; whether there are such measures is known once there is a world.
pub(crate) fn check(settings: &Settings) -> Checked {
    const MOST: usize = 6;
    let all = &settings.descriptors;
    if all.is_empty() || all.len() > MOST {
        let problem = format!("has {}; allowed: 1 to {MOST} measures of behaviour", all.len());
        return refused("evolution.descriptors", problem);
    }
    for (index, descriptor) in all.iter().enumerate() {
        let Descriptor {
            least,
            greatest,
            measure,
            ..
        } = descriptor;
        if least >= greatest || !(greatest - least).is_finite() {
            let problem = format!("is {greatest}; allowed: above `least`, {least}");
            return refused(&format!("evolution.descriptors[{index}].greatest"), problem);
        }
        if all[..index].iter().any(|other| other.measure == *measure) {
            let problem = format!("is {measure:?}, again; allowed: each once");
            return refused(&format!("evolution.descriptors[{index}].measure"), problem);
        }
    }
    Ok(())
}
