//! Whether the robot carries a puck.

use super::kind::{Entry, Feature, Mark};

pub(super) const ENTRY: Entry = Entry {
    features: &[Feature::ReadsPucks],
    mark: Mark::None,
    ..Entry::new(["gripper", "1 while the robot carries a puck, else 0"], |_, _| {
        "select(0.0f, 1.0f, carries_puck(episode))".to_owned()
    })
};
