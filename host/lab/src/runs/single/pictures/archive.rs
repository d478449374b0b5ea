//! The archive of elites, by the two measures that describe their behaviour.

use oneiro_report::figures::HEAT;
use oneiro_report::figures::plot::{Plot, Range};
use oneiro_report::figures::svg::{Anchor, BOLD, SOFT, Svg, ramp};
use oneiro_report::numbers::{Digits, in_figure};

use super::Picture;

pub(super) const PICTURE: Picture = Picture {
    name: "archive.svg",
    about: "a picture of the archive, if two measures describe behaviour",
    caption: "The archive: each square is an elite, where its behaviour is.",
    is_of_champion: false,
    is_drawn: |single| {
        let evolution = &single.experiment.settings().evolution;
        evolution.has_archive() && evolution.descriptors.len() == 2
    },
    draw: |run| {
        let [x, y] = &run.experiment.settings().evolution.descriptors[..] else {
            return None;
        };
        let title = format!("{}, seed {}: elites", run.experiment.name(), run.seed);
        let elites = run.archive?.elites();
        let dots: Vec<[f64; 3]> = elites
            .map(|(_, elite)| [elite.behaviour[0], elite.behaviour[1], elite.fitness])
            .collect();
        let axes = [x, y].map(|axis| (&*axis.measure, [axis.least, axis.greatest].map(f64::from)));
        Some(drawn(&title, axes, &dots))
    },
};

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 640.0;
const LEFT: f64 = 76.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 56.0;
const RIGHT: f64 = 24.0;
/// Size of the square of an elite.
const SIDE: f64 = 9.0;

/// Draws an elite as a square at its behaviour, darker the fitter it is: names and ranges of the two measures, and each elite's
/// values and fitness. Behaviour outside of the ranges is drawn at their ends.
pub(in super::super) fn drawn(title: &str, [across, up]: [(&str, [f64; 2]); 2], elites: &[[f64; 3]]) -> String {
    let plot = Plot {
        left: LEFT,
        right: WIDTH - RIGHT,
        top: TOP,
        bottom: HEIGHT - BOTTOM,
        across: Range::between(across.1[0], across.1[1], 6),
        up: Range::between(up.1[0], up.1[1], 6),
    };
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.words((LEFT, 28.0), 16.0, Anchor::Start, BOLD, title);
    let fitness = || elites.iter().map(|elite| elite[2]);
    let (low, high) = (fitness().fold(f64::NAN, f64::min), fitness().fold(f64::NAN, f64::max));
    if low.is_finite() && high.is_finite() {
        let words = |value: f64| in_figure(value, Digits::Four);
        let key = format!("fitness from {} (light) to {} (dark)", words(low), words(high));
        svg.words((LEFT, 50.0), 12.0, Anchor::Start, SOFT, &key);
    }
    svg.kept(|svg| {
        let size = (plot.right - plot.left, plot.bottom - plot.top);
        svg.rectangle((plot.left, plot.top), size, "fill=\"#ffffff\"");
    });
    plot.axes(&mut svg, across.0, up.0);
    svg.raw("<g data-kept=\"\">");
    for &[x, y, fitness] in elites {
        let share = if high > low {
            (fitness - low) / (high - low)
        } else {
            1.0
        };
        let at = |value: f64, [least, greatest]: [f64; 2]| value.clamp(least, greatest);
        let corner = (plot.x(at(x, across.1)) - 0.5 * SIDE, plot.y(at(y, up.1)) - 0.5 * SIDE);
        let style = format!("fill=\"{}\"", ramp(&HEAT, share));
        svg.rectangle(corner, (SIDE, SIDE), &style);
    }
    svg.raw("</g>");
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_elite_is_a_square_within_the_axes() {
        let axes = [("x", [0.0, 10.0]), ("y", [-1.0, 1.0])];
        let svg = |elites: &[[f64; 3]]| drawn("elites", axes, elites);
        let squares = |svg: &str| svg.matches("<rect").count();
        let none = svg(&[]);
        let some = svg(&[[0.0, -1.0, 3.0], [5.0, 0.0, 4.0], [99.0, 9.0, 5.0]]);
        assert_eq!(squares(&some), squares(&none) + 3);
        assert!(some.contains("fitness from 3 (light) to 5 (dark)"), "{some}");
        let lightest = format!("fill=\"{}\"", ramp(&HEAT, 0.0));
        let darkest = format!("fill=\"{}\"", ramp(&HEAT, 1.0));
        assert!(some.contains(&lightest) && some.contains(&darkest));
    }
}
