//! A network without hidden units: eight sensors and a bias, two motors, and the weights between them.

use oneiro::tables::SENSORS;

use super::svg::{Anchor, BOLD, INK, PLAIN, SOFT, SOFT_INK, Svg, number};
use super::tables::NAMES;
use crate::numbers::fixed;

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 470.0;
/// Centre of the first input, and rows of the inputs and outputs.
const FIRST: f64 = 130.0;
const INPUTS: f64 = 290.0;
const OUTPUTS: f64 = 74.0;
/// Distance between two inputs.
const STEP: f64 = 84.0;
const RADIUS: f64 = 17.0;
/// Line width of the largest weight.
const WIDEST: f64 = 9.0;
/// Colours of positive, negative and missing weights.
const FORWARDS: &str = "#2a7f8f";
const BACKWARDS: &str = "#c8563b";
const UNKNOWN: &str = "#c9ccd3";

/// Draws a network. `weights` are eight and a bias for the left motor, then for the right one; missing ones are drawn
/// grey.
pub fn network(title: &str, weights: &[f32]) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    let greatest = weights.iter().map(|weight| f64::from(weight.abs())).fold(0.0, f64::max);
    let outputs = [("left motor", FIRST + 2.5 * STEP), ("right motor", FIRST + 5.5 * STEP)];
    let input = |i: usize| FIRST + STEP * i as f64;
    for (output, (_, to)) in outputs.iter().enumerate() {
        for i in 0..=SENSORS {
            let weight = weights.get(output * (SENSORS + 1) + i).map(|&weight| f64::from(weight));
            let style = link(weight, greatest);
            svg.line((input(i), INPUTS), (*to, OUTPUTS), &style);
        }
    }
    let node = format!("fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"1.8\"");
    for (words, x) in outputs {
        svg.circle((x, OUTPUTS), RADIUS, &node, words);
        svg.words((x, OUTPUTS - RADIUS - 10.0), 14.0, Anchor::Middle, BOLD, words);
    }
    for (i, name) in NAMES.iter().enumerate() {
        svg.circle((input(i), INPUTS), RADIUS, &node, name);
        svg.words((input(i), INPUTS + 4.5), 13.0, Anchor::Middle, PLAIN, &i.to_string());
        svg.words((input(i), INPUTS + RADIUS + 18.0), 12.0, Anchor::Middle, PLAIN, name);
    }
    let (x, side) = (input(SENSORS), 1.7 * RADIUS);
    svg.rectangle((x - 0.5 * side, INPUTS - 0.5 * side), (side, side), &node);
    svg.words((x, INPUTS + 4.5), 13.0, Anchor::Middle, PLAIN, "1");
    svg.words((x, INPUTS + RADIUS + 18.0), 12.0, Anchor::Middle, PLAIN, "bias");
    // The weights as numbers.
    for (output, words) in ["to the left", "to the right"].iter().enumerate() {
        let y = INPUTS + RADIUS + 52.0 + 24.0 * output as f64;
        svg.words((FIRST - 0.62 * STEP, y), 12.0, Anchor::End, SOFT, words);
        for i in 0..=SENSORS {
            let weight = weights.get(output * (SENSORS + 1) + i);
            let (words, colour) = weight.map_or(("\u{2013}".to_owned(), SOFT_INK), |&weight| {
                let text = fixed(weight.into(), 2);
                let words = match text.strip_prefix('-') {
                    Some(size) => format!("\u{2212}{size}"),
                    None => format!("+{text}"),
                };
                (words, colour(f64::from(weight)))
            });
            let style = format!("fill=\"{colour}\" font-weight=\"600\"");
            svg.words((input(i), y), 13.0, Anchor::Middle, &style, &words);
        }
    }
    let y = HEIGHT - 28.0;
    for (x, colour, words) in [
        (FIRST, FORWARDS, "drives the wheel forwards"),
        (FIRST + 3.2 * STEP, BACKWARDS, "drives it backwards"),
    ] {
        svg.line(
            (x, y),
            (x + 36.0, y),
            &format!("stroke=\"{colour}\" stroke-width=\"5\""),
        );
        svg.words((x + 44.0, y + 4.5), 12.0, Anchor::Start, PLAIN, words);
    }
    svg.words(
        (FIRST + 5.6 * STEP, y + 4.5),
        12.0,
        Anchor::Start,
        SOFT,
        "width: size of the weight",
    );
    svg.finish()
}

/// Style of a weight's line.
fn link(weight: Option<f64>, greatest: f64) -> String {
    let Some(weight) = weight else {
        return format!("stroke=\"{UNKNOWN}\" stroke-width=\"1\"");
    };
    let width = 0.4 + WIDEST * weight.abs() / greatest.max(f64::MIN_POSITIVE);
    format!(
        "stroke=\"{}\" stroke-width=\"{}\" stroke-opacity=\"0.78\"",
        colour(weight),
        number(width)
    )
}

fn colour(weight: f64) -> &'static str {
    if weight < 0.0 { BACKWARDS } else { FORWARDS }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_weight_has_a_line_and_a_number() {
        let weights: Vec<f32> = (0..18).map(|i| i as f32 * 0.5 - 4.0).collect();
        let text = network("t", &weights);
        let of = |colour: &str| {
            text.lines()
                .filter(|line| line.contains(&format!("stroke=\"{colour}\"")) && line.contains("opacity"))
                .count()
        };
        assert_eq!((of(BACKWARDS), of(FORWARDS)), (8, 10));
        assert!(text.contains(">\u{2212}4.00<") && text.contains(">+4.50<"));
    }

    #[test]
    fn the_greatest_weight_is_the_widest() {
        let width = |style: &str| style.split('"').nth(3).and_then(|width| width.parse::<f64>().ok());
        assert_eq!(width(&link(Some(-2.0), 2.0)), Some(WIDEST + 0.4));
        assert_eq!(width(&link(Some(0.0), 0.0)), Some(0.4));
    }

    #[test]
    fn a_network_without_weights_is_grey() {
        let text = network("t", &[]);
        assert_eq!(text.matches(UNKNOWN).count(), 18);
        assert_eq!(text.matches(">\u{2013}<").count(), 18);
    }
}
