//! Sight of other robots, and of pucks.

use std::fmt::Write;

use super::kind::{Entry, Feature, Mark};
use super::ray::DISTANCE;
use super::text::{Each, Text};

pub(super) const ROBOT: Entry = Entry {
    keys: &["heading_turns", "range_mm"],
    features: &[Feature::ReadsRobots],
    numbers: DISTANCE.numbers,
    reach: DISTANCE.reach,
    mark: Mark::Ray,
    ..Entry::new(
        ["sight", "1 if what a ray meets first is another robot, else 0"],
        |text, each| {
            let [wanted, others] = seen(text, each);
            text.others += &wanted;
            text.pucks += &others;
            is_first(each)
        },
    )
};

pub(super) const PUCK: Entry = Entry {
    name: "puck",
    about: "1 if what a ray meets first is a puck, else 0",
    features: &[Feature::ReadsRobots, Feature::ReadsPucks],
    write: |text, each| {
        let [wanted, others] = seen(text, each);
        text.pucks += &wanted;
        text.others += &others;
        is_first(each)
    },
    ..ROBOT
};

/// Writes the ray, and returns the code for each body that is wanted, and for each other body.
fn seen(text: &mut Text, each: &Each<'_>) -> [String; 2] {
    let index = each.index;
    let _ = writeln!(
        text.numbers,
        "    let ahead{index} = cosine_sine(looks{index});
    var free{index} = s{index}.offset + s{index}.range;
    var seen{index} = s{index}.offset + s{index}.range;"
    );
    text.rays.push(index);
    ["seen", "free"].map(|nearest| {
        format!(
            "            {nearest}{index} = min({nearest}{index}, ray_to_body(to, ahead{index}, body_squared, {nearest}{index}));\n"
        )
    })
}

fn is_first(Each { index, .. }: &Each<'_>) -> String {
    format!("select(0.0f, 1.0f, seen{index} < free{index})")
}
