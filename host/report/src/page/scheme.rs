//! Figures in the dark scheme: files have colours on white paper, and a page replaces them by its style.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::figures::HEAT;

type Colour = [f64; 3];

/// Colours of figures that are variables of pages.
const VARIABLES: [(&str, &str); 4] = [
    ("#ffffff", "paper"),
    ("#33363f", "ink"),
    ("#6b6e76", "soft"),
    ("#e4e5e8", "rule"),
];
/// Pages' ink and paper in the dark scheme.
const INK: Colour = [228.0, 229.0, 233.0];
const PAPER: Colour = [23.0, 25.0, 29.0];
/// The minimum contrast of a line or a name with the paper (WCAG 2).
const CONTRAST: f64 = 4.5;
/// Greys have channels that differ less than this.
const GREY: f64 = 24.0;
/// Relative luminance from which a colour is a tint of the paper, and how much of it a dark tint has.
const LIGHT: f64 = 0.78;
const TINT: f64 = 0.16;

/// The colours of all figures and dots of a page.
fn colours(html: &str) -> BTreeSet<&str> {
    let marks = ["fill=\"", "stroke=\"", "background:"];
    let after = marks.iter().flat_map(|mark| html.split(mark).skip(1));
    let colours = after.filter_map(|rest| rest.get(..7));
    colours
        .filter(|own| own.starts_with('#') && own[1..].bytes().all(|digit| digit.is_ascii_hexdigit()))
        .collect()
}

/// Rules for the colours of a page's figures, which its style needs in the dark scheme. Shades of a scale keep theirs, since captions say which
/// is darker. A group with `data-kept`, such as numbers on them, also keeps its colours.
pub(super) fn rules(html: &str) -> String {
    dark_rules("", colours(html))
}

/// The same for charts within an element that come later, whose lines have these colours.
pub fn dark_rules<'a>(within: &str, colours: impl IntoIterator<Item = &'a str>) -> String {
    let variables = VARIABLES.iter().map(|(colour, _)| *colour);
    let mut rules = String::new();
    for colour in colours.into_iter().chain(variables).collect::<BTreeSet<_>>() {
        let dark = match VARIABLES.iter().find(|(known, _)| *known == colour) {
            Some((_, name)) => format!("var(--{name})"),
            None => dark(colour),
        };
        let kept = if is_shade(colour) {
            "[data-kept] *, rect, [shape-rendering]"
        } else {
            "[data-kept] *"
        };
        for property in ["fill", "stroke"] {
            // Writing to a string can't fail.
            let _ = writeln!(
                rules,
                "{within}svg [{property}=\"{colour}\"]:not({kept}) {{ {property}: {dark}; }}"
            );
        }
        let _ = writeln!(
            rules,
            "[style=\"background:{colour}\"] {{ background: {dark} !important; }}"
        );
    }
    format!("@media screen and (prefers-color-scheme: dark) {{\n{rules}}}\n")
}

/// Whether a colour is of the scale of readings and means, whose squares are rectangles or have sharp edges; floors also have one.
fn is_shade(colour: &str) -> bool {
    let own = channels(colour);
    HEAT.windows(2).any(|ends| {
        let [from, to] = [ends[0], ends[1]].map(|end| end.map(f64::from));
        let along: f64 = (0..3).map(|i| (own[i] - from[i]) * (to[i] - from[i])).sum();
        let length: f64 = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum();
        let nearest = mixed(from, to, (along / length).clamp(0.0, 1.0));
        (0..3).all(|i| (own[i] - nearest[i]).abs() <= 1.0)
    })
}

fn channels(colour: &str) -> Colour {
    [1, 3, 5].map(|at| f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap_or(0)))
}

/// A colour in the dark scheme: greys change places, tints become dark ones, and others become as light as they must be to be read.
fn dark(colour: &str) -> String {
    let own = channels(colour);
    let spread = own.iter().copied().fold(0.0, f64::max) - own.iter().copied().fold(255.0, f64::min);
    let [red, green, blue] = if spread < GREY {
        std::array::from_fn(|i| INK[i] + (PAPER[i] - INK[i]) * own[i] / 255.0)
    } else if luminance(own) > LIGHT {
        mixed(PAPER, own, TINT)
    } else {
        let lighter = (0..=20).map(|part| mixed(own, [255.0; 3], f64::from(part) / 20.0));
        let legible = |own: &Colour| (luminance(*own) + 0.05) / (luminance(PAPER) + 0.05) >= CONTRAST;
        lighter.into_iter().find(legible).unwrap_or(INK)
    }
    .map(|part| part.round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn mixed(from: Colour, to: Colour, part: f64) -> Colour {
    std::array::from_fn(|i| from[i] + (to[i] - from[i]) * part)
}

/// Relative luminance.
fn luminance(colour: Colour) -> f64 {
    let linear = |part: f64| {
        let part = part / 255.0;
        if part <= 0.04045 {
            part / 12.92
        } else {
            ((part + 0.055) / 1.055).powf(2.4)
        }
    };
    let [red, green, blue] = colour.map(linear);
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::svg::ramp;

    #[test]
    fn lines_become_light_and_tints_dark() {
        assert_eq!(dark("#000000"), "#e4e5e9");
        assert_eq!(dark("#fefefe"), "#181a1e");
        // Already light enough.
        assert_eq!(dark("#f4a23b"), "#f4a23b");
        for (colour, least, most) in [
            ("#2b3a8f", 4.5, 6.0),
            ("#c8374f", 4.5, 6.0),
            ("#fbf3dc", 1.05, 2.0),
            ("#c9ccd3", 1.3, 3.0),
        ] {
            let own = channels(&dark(colour));
            let contrast = (luminance(own) + 0.05) / (luminance(PAPER) + 0.05);
            assert!((least..most).contains(&contrast), "{colour}: {contrast}");
        }
    }

    #[test]
    fn shades_of_a_scale_are_kept_and_floors_not() {
        for shade in 0..32 {
            let colour = ramp(&HEAT, f64::from(shade) / 31.0);
            let rules = dark_rules("", [&*colour]);
            assert!(
                rules.contains(&format!(
                    "svg [fill=\"{colour}\"]:not([data-kept] *, rect, [shape-rendering])"
                )),
                "{rules}"
            );
        }
        for other in ["#2b3a8f", "#2a9d8f", "#ffffff", "#33363f", "#9db8dd"] {
            assert!(!is_shade(other), "{other}");
        }
    }

    #[test]
    fn each_colour_of_a_page_has_its_rules() {
        let html = "<p>#123456</p><rect fill=\"#ffffff\"/><path fill=\"none\" stroke=\"#2b3a8f\"/><i style=\"background:#2b3a8f\"></i>";
        assert_eq!(colours(html).into_iter().collect::<Vec<_>>(), ["#2b3a8f", "#ffffff"]);
        let rules = rules(html);
        assert!(
            rules.contains("svg [fill=\"#ffffff\"]:not([data-kept] *) { fill: var(--paper); }"),
            "{rules}"
        );
    }
}
