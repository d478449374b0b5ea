//! The scores of a tournament of generations.

use std::fmt::Write;

use super::plot::{Plot, Range};
use super::svg::{Anchor, BOLD, SOFT, Svg, number, ramp};
use super::tables::HEAT;
use crate::numbers::{Digits, in_figure};

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 660.0;
const LEFT: f64 = 76.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 56.0;
const RIGHT: f64 = 24.0;
/// Number of shades. Neighbours of the same shade are drawn as one rectangle, and all rectangles of a shade as one path, which keeps the
/// file small.
const SHADES: usize = 16;

/// Draws `count` times `count` scores as squares, darker the more the first of two populations scores; they are by its generations,
/// drawn upwards, and then by those of the second. Generations are `every` apart. NaN is white.
pub fn tournament(title: &str, every: u32, count: usize, scores: &[f64]) -> String {
    let last = (count as f64 * f64::from(every)).max(1.0);
    let axis = || Range::between(0.0, last, 6);
    let plot = Plot {
        left: LEFT,
        right: WIDTH - RIGHT,
        top: TOP,
        bottom: HEIGHT - BOTTOM,
        across: axis(),
        up: axis(),
    };
    let numbers = || scores.iter().copied().filter(|score| !score.is_nan());
    let (low, high) = (numbers().fold(f64::NAN, f64::min), numbers().fold(f64::NAN, f64::max));
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.words((LEFT, 28.0), 16.0, Anchor::Start, BOLD, title);
    let key = format!(
        "score of the first population from {} (light) to {} (dark)",
        in_figure(low, Digits::Four),
        in_figure(high, Digits::Four)
    );
    svg.words((LEFT, 50.0), 12.0, Anchor::Start, SOFT, &key);
    plot.axes(
        &mut svg,
        "generation of the second population",
        "generation of the first",
    );
    let shade = |score: f64| {
        let share = if high > low { (score - low) / (high - low) } else { 0.5 };
        (share * (SHADES - 1) as f64).round()
    };
    let at = |place: usize| place as f64 * f64::from(every);
    let mut paths = vec![String::new(); SHADES];
    for (row, scores) in scores.chunks_exact(count.max(1)).enumerate() {
        let (top, bottom) = (plot.y(at(row + 1)), plot.y(at(row)));
        let mut column = 0;
        for same in scores.chunk_by(|a, b| shade(*a) == shade(*b)) {
            let (from, to) = (plot.x(at(column)), plot.x(at(column + same.len())));
            column += same.len();
            if !same[0].is_nan() {
                let [x, y, width, height] = [from, top, to - from, bottom - top].map(number);
                // Writing to a string can't fail.
                let _ = write!(paths[shade(same[0]) as usize], "M{x},{y}h{width}v{height}h-{width}z");
            }
        }
    }
    svg.kept(|svg| {
        for (place, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
            let colour = ramp(&HEAT, place as f64 / (SHADES - 1) as f64);
            svg.raw(&format!("<path fill=\"{colour}\" d=\"{path}\"/>"));
        }
    });
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_of_one_shade_are_one_rectangle() {
        let squares = |scores: &[f64]| tournament("t", 1, 2, scores).matches('z').count();
        let none = squares(&[f64::NAN; 4]);
        assert_eq!(squares(&[0.0, 1.0, 1.0, 0.0]), none + 4);
        assert_eq!(squares(&[0.0, 0.0, 1.0, 0.0]), none + 3);
        assert_eq!(squares(&[0.0, f64::NAN, 1.0, 1.0]), none + 2);
        // A path for each shade.
        assert_eq!(tournament("t", 1, 2, &[0.0, 1.0, 1.0, 0.0]).matches("<path").count(), 2);
        let text = tournament("t", 1, 2, &[0.0, 0.25, 1.0, 0.0]);
        assert!(text.contains(&format!("fill=\"{}\"", ramp(&HEAT, 1.0))), "{text}");
        assert!(text.contains("from 0 (light) to 1 (dark)"), "{text}");
    }
}
