//! A Khepera from above, to scale: described by a paper, and sampled.

use super::svg::{Anchor, BOLD, INK, PLAIN, SOFT, SOFT_INK, Svg};

/// Pixels to a millimetre.
const SCALE: f64 = 3.0;
/// Width and height of a panel, in pixels.
const PANEL: (f64, f64) = (470.0, 490.0);
/// Distance between its wheels, and their length and width, mm.
const WHEELS: f64 = 53.0;
const WHEEL: (f64, f64) = (14.0, 3.0);
/// Side of a sensor, mm.
const SENSOR: f64 = 4.0;

/// A proximity sensor on the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Degrees clockwise from straight ahead.
    pub bearing: f64,
    /// Distance at which a wall makes it read one half, mm.
    pub half: f64,
}

/// Draws a robot with sensors at some bearings and the dimensions that a paper prints, and next to it one whose sensors' ranges are known.
/// Radii are in mm.
pub fn khepera(printed_radius: f64, bearings: &[f64], printed: &[&str], radius: f64, eyes: &[Eye]) -> String {
    let mut svg = Svg::new(2.0 * PANEL.0, PANEL.1, "A Khepera with its eight sensors, from above");
    let middle = |panel: f64| ((panel + 0.5) * PANEL.0, 0.51 * PANEL.1);
    let (left, right) = (middle(0.0), middle(1.0));
    title(&mut svg, left, "As the paper describes it");
    body(&mut svg, left, printed_radius);
    for (place, bearing) in bearings.iter().enumerate() {
        sensor(&mut svg, left, printed_radius, *bearing);
        number(&mut svg, left, printed_radius + 9.0, *bearing, &(place + 1).to_string());
    }
    let below = left.1 + SCALE * printed_radius + 64.0;
    let ends = [left.0 - SCALE * printed_radius, left.0 + SCALE * printed_radius];
    let style = format!("stroke=\"{INK}\" stroke-width=\"1.2\"");
    svg.line((ends[0], below), (ends[1], below), &style);
    for end in ends {
        svg.line((end, below - 5.0), (end, below + 5.0), &style);
    }
    svg.words(
        (left.0, below - 6.0),
        13.0,
        Anchor::Middle,
        PLAIN,
        &format!("{} mm", 2.0 * printed_radius),
    );
    for (line, words) in printed.iter().enumerate() {
        svg.words(
            (left.0, below + 18.0 + 15.0 * line as f64),
            12.0,
            Anchor::Middle,
            SOFT,
            words,
        );
    }
    title(&mut svg, right, "As it was sampled");
    body(&mut svg, right, radius);
    for (place, eye) in eyes.iter().enumerate() {
        let end = at(right, radius + eye.half, eye.bearing);
        svg.line(
            at(right, radius, eye.bearing),
            end,
            "stroke=\"#c8374f\" stroke-width=\"2\"",
        );
        sensor(&mut svg, right, radius, eye.bearing);
        let words = format!("{}: {:.0} mm", place + 1, eye.half);
        number(&mut svg, right, radius + eye.half + 9.0, eye.bearing, &words);
    }
    svg.words(
        (right.0, PANEL.1 - 12.0),
        12.0,
        Anchor::Middle,
        SOFT,
        "red: how far from a wall it reads one half",
    );
    svg.finish()
}

/// The place at a distance from the middle, in mm, and a bearing.
fn at(middle: (f64, f64), distance: f64, bearing: f64) -> (f64, f64) {
    let (sine, cosine) = bearing.to_radians().sin_cos();
    (middle.0 + SCALE * distance * sine, middle.1 - SCALE * distance * cosine)
}

fn title(svg: &mut Svg, middle: (f64, f64), words: &str) {
    svg.words((middle.0, 22.0), 14.0, Anchor::Middle, BOLD, words);
}

/// The body with its wheels, and an arrow straight ahead.
fn body(svg: &mut Svg, middle: (f64, f64), radius: f64) {
    let style = format!("fill=\"{SOFT_INK}\" fill-opacity=\"0.07\" stroke=\"{INK}\" stroke-width=\"1.5\"");
    svg.circle(middle, SCALE * radius, &style, "body");
    for side in [-0.5, 0.5] {
        let corner = (
            middle.0 + SCALE * (side * WHEELS - 0.5 * WHEEL.1),
            middle.1 - SCALE * 0.5 * WHEEL.0,
        );
        svg.rectangle(corner, (SCALE * WHEEL.1, SCALE * WHEEL.0), &format!("fill=\"{INK}\""));
    }
    let tip = at(middle, 0.5 * radius, 0.0);
    svg.line(middle, tip, &format!("stroke=\"{SOFT_INK}\" stroke-width=\"1.5\""));
    let head = [(tip.0 - 4.0, tip.1 + 7.0), tip, (tip.0 + 4.0, tip.1 + 7.0)];
    svg.polyline(head, &format!("stroke=\"{SOFT_INK}\" stroke-width=\"1.5\""));
}

fn sensor(svg: &mut Svg, middle: (f64, f64), radius: f64, bearing: f64) {
    let side = SCALE * SENSOR;
    let (x, y) = at(middle, radius - 0.5 * SENSOR, bearing);
    svg.raw(&format!("<g transform=\"rotate({bearing:.1} {x:.2} {y:.2})\">"));
    svg.rectangle(
        (x - 0.5 * side, y - 0.5 * side),
        (side, side),
        &format!("fill=\"#2b3a8f\" stroke=\"{INK}\""),
    );
    svg.raw("</g>");
}

fn number(svg: &mut Svg, middle: (f64, f64), distance: f64, bearing: f64, words: &str) {
    let (x, y) = at(middle, distance, bearing);
    let anchor = match bearing.to_radians().sin() {
        sine if sine > 0.4 => Anchor::Start,
        sine if sine < -0.4 => Anchor::End,
        _ => Anchor::Middle,
    };
    svg.words((x, y + 4.0), 12.0, anchor, PLAIN, words);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 55 mm are 165 pixels, and a sensor that sees farther has a longer line.
    #[test]
    fn robots_are_to_scale() {
        let eyes = [(-90.0, 10.0), (90.0, 30.0)].map(|(bearing, half)| Eye { bearing, half });
        let svg = khepera(27.5, &[-90.0, 90.0], &["30 mm high"], 27.5, &eyes);
        assert_eq!(svg.matches("r=\"82.5\"").count(), 2);
        assert!(svg.contains(">55 mm<") && svg.contains(">30 mm high<") && svg.contains(">2: 30 mm<"));
        // From the rim, 82.5 pixels next to 705.
        assert!(svg.contains("x1=\"787.5\"") && svg.contains("x2=\"877.5\""), "{svg}");
        assert!(svg.contains("x1=\"622.5\"") && svg.contains("x2=\"592.5\""), "{svg}");
        assert_eq!(svg.matches("<g transform=\"rotate(").count(), 4);
    }
}
