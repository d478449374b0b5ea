//! Distance and proximity: how far a ray is free.

use std::fmt::Write;

use super::kind::{Counterpart, Entry, Feature, Mark, Scale};
use super::text::{Each, Text};

pub(super) const DISTANCE: Entry = Entry {
    keys: &["heading_turns", "bearing_turns", "range_mm", "offset_mm"],
    features: &[Feature::Analogue],
    mounting: Some(|turns, _| [turns, 1.0]),
    numbers: |sensor, _| {
        let range = sensor.range.unwrap_or(1.0);
        [range, 1.0 / range]
    },
    reach: |sensor, around| sensor.offset.unwrap_or(around.body_radius) + sensor.range.unwrap_or(0.0),
    mark: Mark::Ray,
    counterpart: Some(Counterpart {
        kind: "distance",
        scale: Scale::Range,
        nearness: -1.0,
    }),
    ..Entry::new(
        [
            "distance",
            "distance to the nearest object along a ray, as a fraction of the range: 1 if there is none",
        ],
        |text, each| {
            let free = free(text, each, false);
            format!("range_share(s{}, {free})", each.index)
        },
    )
};

pub(super) const PROXIMITY: Entry = Entry {
    name: "proximity",
    about: "one minus the distance to the nearest object along a ray, as a fraction of the range: 0 if there is none",
    keys: &["heading_turns", "bearing_turns", "range_mm", "offset_mm", "response"],
    features: &[
        Feature::Analogue,
        Feature::SeesLight,
        Feature::SeesSurfaces,
        Feature::SeesNearness,
    ],
    mounting: Some(|turns, stronger| [turns, 1.0 / stronger]),
    reach: |sensor, around| sensor.offset.unwrap_or(around.body_radius) + around.farther * sensor.range.unwrap_or(0.0),
    counterpart: Some(Counterpart {
        kind: "proximity",
        scale: Scale::Greatest,
        nearness: 1.0,
    }),
    write: |text, each| {
        let index = each.index;
        let free = free(text, each, each.is_individual);
        match each.response {
            Some([first, points]) => format!("response_reading(world, s{index}, {free}, {first}u, {points}u)"),
            None => format!("1.0f - range_share(s{index}, {free})"),
        }
    },
    ..DISTANCE
};

/// Writes how far a ray is free, and returns the expression. Where objects seem to be farther or nearer than they are, by the light
/// that they return, it is how far it seems to be.
fn free(text: &mut Text, each: &Each<'_>, seems: bool) -> String {
    let (index, outward) = (each.index, each.outward());
    let Text {
        numbers,
        objects,
        others,
        pucks,
        rays,
        ..
    } = text;
    let _ = writeln!(numbers, "    let ahead{index} = cosine_sine(looks{index});");
    let ray = if seems {
        let _ = writeln!(numbers, "    let far{index} = with_farther_sight(s{index});");
        let _ = writeln!(numbers, "    var seeming{index} = 1.0f;");
        format!("far{index}")
    } else {
        format!("s{index}")
    };
    let _ = writeln!(numbers, "    var free{index} = {ray}.offset + {ray}.range;");
    let is_at_centre = each.sensor.bearing.is_none();
    let seen = if is_at_centre {
        format!("ray_to_body(to, ahead{index}, body_squared, free{index})")
    } else {
        format!("body_from_place(to, outward{index}, ahead{index}, body_squared, {ray})")
    };
    let seen = format!("            free{index} = min(free{index}, {seen});\n");
    *others += &seen;
    *pucks += &seen;
    let nearest = if is_at_centre {
        format!("ray_to_shape(shape, at, ahead{index}, free{index})")
    } else {
        let _ = writeln!(numbers, "    let outward{index} = {outward};");
        format!("free_from_place(shape, at, outward{index}, ahead{index}, {ray})")
    };
    if !seems {
        if is_at_centre {
            rays.push(index);
        } else {
            let _ = writeln!(objects, "            free{index} = min(free{index}, {nearest});");
        }
        return format!("free{index}");
    }
    let _ = writeln!(objects, "            let here{index} = {nearest};");
    let _ = writeln!(
        objects,
        "            seeming{index} = select(seeming{index}, shapes[shape].reflectivity, here{index} < free{index});"
    );
    let _ = writeln!(objects, "            free{index} = min(free{index}, here{index});");
    let share = format!("seeming{index} * (seeming_share(gain) * {})", each.strength());
    format!("seemingly_free(s{index}, free{index}, {share})")
}

/// How far an object leaves rays from the body's centre free. Common values of the rays of one kind of object are computed once.
pub(crate) fn of_an_object(rays: &[usize]) -> String {
    if rays.is_empty() {
        return String::new();
    }
    let meet = |kind: &str| {
        let ray = |index: &usize| {
            format!(
                "                free{index} = min(free{index}, ray_to_{kind}(shape, at, ahead{index}, free{index}));\n"
            )
        };
        rays.iter().map(ray).collect::<String>()
    };
    format!(
        "            if (shapes[shape].kind == ROUND) {{
{}            }} else if (shapes[shape].kind == BLOCK) {{
{}            }} else {{
{}            }}
",
        meet("round"),
        meet("block"),
        meet("wall"),
    )
}
