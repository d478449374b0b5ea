//! Sensors of light, and how the brightness of lights falls with their distance.

use super::kind::{Counterpart, Entry, Feature, Mark, Scale};
use crate::parameter::{Choice, Choices};

pub(super) const ENTRY: Entry = Entry {
    keys: &["heading_turns", "bearing_turns", "range_mm", "offset_mm", "law"],
    features: &[Feature::Analogue, Feature::SeesLight, Feature::ReadsLights],
    mounting: Some(|turns, stronger| [turns, stronger]),
    numbers: |sensor, _| {
        [
            f32::from(sensor.law.unwrap_or_default() as u8),
            1.0 / sensor.range.unwrap_or(1.0),
        ]
    },
    mark: Mark::Direction,
    counterpart: Some(Counterpart {
        kind: "light",
        scale: Scale::Rest,
        nearness: 0.0,
    }),
    ..Entry::new(
        [
            "light",
            "the brightness of all lights that no object hides, by their distance and direction",
        ],
        |_, each| {
            let reading = format!("light_reading(world, {}, {})", each.place(), each.arguments());
            if each.is_individual {
                return format!("min(flushed({reading} * (gain * {})), 1.0f)", each.strength());
            }
            reading
        },
    )
};

/// How the brightness of a light falls with its distance in ranges, `d`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// `1 - d`, and 0 from the range on.
    #[default]
    Linear,
    /// `exp(-d)`.
    Exponential,
    /// `1 / (1 + d^2)`.
    InverseSquare,
}

impl Choice for Law {
    const CHOICES: Choices<Self> = &[
        ("linear", Self::Linear, "1 - d, and 0 from the range on"),
        ("exponential", Self::Exponential, "exp(-d)"),
        ("inverse_square", Self::InverseSquare, "1 / (1 + d^2)"),
    ];
}
