//! Sight of other robots.

use std::fmt::Write;

use super::kind::{Entry, Feature, Mark};
use super::ray::DISTANCE;

pub(super) const ENTRY: Entry = Entry {
    keys: &["heading_turns", "range_mm"],
    features: &[Feature::ReadsRobots],
    numbers: DISTANCE.numbers,
    reach: DISTANCE.reach,
    mark: Mark::Ray,
    ..Entry::new(
        ["sight", "1 if what a ray meets first is another robot, else 0"],
        |text, each| {
            let index = each.index;
            let _ = writeln!(text.numbers, "    let ahead{index} = cosine_sine(looks{index});");
            let far = format!("s{index}.offset + s{index}.range");
            let _ = writeln!(
                text.numbers,
                "    var free{index} = {far};\n    var seen{index} = {far};"
            );
            let _ = writeln!(
                text.others,
                "            seen{index} = min(seen{index}, ray_to_body(to, ahead{index}, body_squared, seen{index}));"
            );
            text.rays.push(index);
            format!("select(0.0f, 1.0f, seen{index} < free{index})")
        },
    )
};
