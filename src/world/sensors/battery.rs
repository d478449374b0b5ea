//! The charge of the robot's battery.

use super::kind::{Entry, Feature, Mark};

pub(super) const ENTRY: Entry = Entry {
    features: &[Feature::ReadsBattery],
    mark: Mark::Ray,
    ..Entry::new(
        ["battery", "charge of the battery, from 1 for full to 0 for empty"],
        |_, _| "battery_reading(world, robot.used)".to_owned(),
    )
};
