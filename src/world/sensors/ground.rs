//! Sensors of the floor.

use super::kind::{Counterpart, Entry, Feature, Mark, Scale};

pub(super) const ENTRY: Entry = Entry {
    keys: &["heading_turns", "offset_mm"],
    features: &[Feature::Analogue, Feature::SeesSurfaces, Feature::ReadsFloor],
    mounting: Some(|_, stronger| [0.0, stronger]),
    mark: Mark::Dot,
    counterpart: Some(Counterpart {
        kind: "ground",
        scale: Scale::Greatest,
        nearness: 0.0,
    }),
    ..Entry::new(
        ["ground", "grey of the floor below it, from 0 for black to 1 for white"],
        |_, each| {
            let reading = format!("ground_reading(world, {})", each.place());
            if each.is_individual {
                return format!("min({reading} * {}, 1.0f)", each.strength());
            }
            reading
        },
    )
};
