//! Values for each pair of levels of two factors, as squares that are darker for greater values.

use super::plot::label_room;
use super::svg::{Anchor, BOLD, INK, PLAIN, SOFT, SOFT_INK, Svg, ramp};
use super::tables::HEAT;
use crate::numbers::{Digits, in_figure};

/// Significant digits of the numbers in the squares.
const DIGITS: Digits = Digits::Four;
const TOP: f64 = 78.0;
const BOTTOM: f64 = 62.0;
const RIGHT: f64 = 16.0;
/// Minimum and maximum width of a square, and the total width that the squares should have.
const WIDTHS: (f64, f64) = (68.0, 132.0);
const ALL: f64 = 900.0;
const HEIGHT: f64 = 50.0;
/// Minimum width of the picture, so that the key fits in.
const LEAST: f64 = 560.0;
/// Approximate width of a letter of a tick's name.
const LETTER: f64 = 6.6;
/// Width of the key, and the number of its shades.
const KEY: f64 = 160.0;
const SHADES: u32 = 32;

/// One of the two factors.
pub struct Side<'a> {
    pub name: &'a str,
    /// Levels from left to right, or from bottom to top.
    pub levels: &'a [&'a str],
}

/// Result of the runs with two levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Mean; NaN if no run has a value.
    pub mean: f64,
    /// Number of runs with a value; if none has one, number of all runs.
    pub runs: usize,
}

/// Two factors and the values for all pairs of their levels.
pub struct HeatMap<'a> {
    pub across: Side<'a>,
    pub up: Side<'a>,
    /// Name of the value with its unit.
    pub value: &'a str,
    /// Values of the lightest and the darkest shade.
    pub low: f64,
    pub high: f64,
    /// Squares by row from the bottom, each row from left to right; `None` if there is no run.
    pub squares: &'a [Option<Square>],
    /// Whether less is better.
    pub is_less_better: bool,
}

/// Draws the squares with their numbers; the best has a frame.
pub fn heat_map(map: &HeatMap<'_>) -> String {
    let columns = map.across.levels.len().max(1);
    let rows = map.squares.len().div_ceil(columns);
    let longest = map.across.levels.iter().map(|level| level.chars().count()).max();
    let least = (LETTER * longest.unwrap_or(0) as f64 + 10.0).clamp(WIDTHS.0, WIDTHS.1);
    let width = (ALL / columns as f64).clamp(least, WIDTHS.1);
    let left = 40.0 + label_room(map.up.levels.iter().copied());
    let sheet = (left + width * columns as f64 + RIGHT).max(LEAST);
    let bottom = TOP + HEIGHT * rows as f64;
    let title = format!("{} by {} and {}", map.value, map.across.name, map.up.name);
    let mut svg = Svg::new(sheet, bottom + BOTTOM, &title);
    svg.words((left, 24.0), 14.0, Anchor::Start, BOLD, map.value);
    key(&mut svg, map, left);
    let best = best(map);
    for (place, square) in map.squares.iter().enumerate() {
        let (row, column) = (place / columns, place % columns);
        let corner = (left + width * column as f64, bottom - HEIGHT * (row + 1) as f64);
        draw(&mut svg, map, square.as_ref(), corner, width);
    }
    if let Some(place) = best {
        let corner = (
            left + width * (place % columns) as f64 + 2.0,
            bottom - HEIGHT * (place / columns + 1) as f64 + 2.0,
        );
        let style = format!("fill=\"none\" stroke=\"{FRAME}\" stroke-width=\"3\"");
        svg.rectangle(corner, (width - 4.0, HEIGHT - 4.0), &style);
    }
    names(&mut svg, map, (left, bottom), (width, rows));
    svg.finish()
}

/// Colour of the best one's frame, used for nothing else in the picture.
const FRAME: &str = "#d98e04";

/// Index of the best, and of the first one if several are equal.
fn best(map: &HeatMap<'_>) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (place, square) in map.squares.iter().enumerate() {
        let Some(Square { mean, .. }) = square else { continue };
        let merit = if map.is_less_better { -mean } else { *mean };
        if merit.is_finite() && best.is_none_or(|(_, greatest)| merit > greatest) {
            best = Some((place, merit));
        }
    }
    best.map(|(place, _)| place)
}

/// Position of a value between the lightest (0) and the darkest (1) shade.
fn share(map: &HeatMap<'_>, value: f64) -> f64 {
    if map.high > map.low {
        (value - map.low) / (map.high - map.low)
    } else {
        0.5
    }
}

fn draw(svg: &mut Svg, map: &HeatMap<'_>, square: Option<&Square>, (x, y): (f64, f64), width: f64) {
    let middle = x + 0.5 * width;
    let Some(&Square { mean, runs }) = square else {
        let style = "fill=\"#ffffff\" stroke=\"#c9cbd1\" stroke-dasharray=\"3 3\"";
        svg.rectangle((x + 1.5, y + 1.5), (width - 3.0, HEIGHT - 3.0), style);
        let style = format!("fill=\"{SOFT_INK}\" font-style=\"italic\"");
        svg.words((middle, y + 0.5 * HEIGHT + 4.0), 11.0, Anchor::Middle, &style, "no run");
        return;
    };
    let runs = format!("{runs} run{}", if runs == 1 { "" } else { "s" });
    let (ground, ink, words) = if mean.is_finite() {
        let share = share(map, mean);
        let ink = if share > 0.5 { "#ffffff" } else { INK };
        (ramp(&HEAT, share), ink, in_figure(mean, DIGITS))
    } else {
        ("#ffffff".to_owned(), INK, "no number".to_owned())
    };
    svg.kept(|svg| {
        let style = format!("fill=\"{ground}\" stroke=\"#ffffff\" stroke-width=\"1.5\"");
        svg.rectangle((x, y), (width, HEIGHT), &style);
        let style = format!("fill=\"{ink}\" font-weight=\"600\"");
        svg.words((middle, y + 23.0), 13.0, Anchor::Middle, &style, &words);
        let style = format!("fill=\"{ink}\"");
        svg.words((middle, y + 39.0), 10.5, Anchor::Middle, &style, &runs);
    });
}

/// Draws the key to the shades.
fn key(svg: &mut Svg, map: &HeatMap<'_>, left: f64) {
    if !map.high.is_finite() || !map.low.is_finite() {
        return;
    }
    let words = |value: f64| in_figure(value, DIGITS);
    let low = words(map.low);
    svg.words((left, 51.0), 12.0, Anchor::Start, SOFT, &low);
    let from = left + 8.0 + 7.0 * low.chars().count() as f64;
    let part = KEY / f64::from(SHADES);
    svg.kept(|svg| {
        for shade in 0..SHADES {
            let style = format!("fill=\"{}\"", ramp(&HEAT, f64::from(shade) / f64::from(SHADES - 1)));
            svg.rectangle((from + part * f64::from(shade), 41.0), (part + 0.3, 11.0), &style);
        }
    });
    svg.words((from + KEY + 8.0, 51.0), 12.0, Anchor::Start, SOFT, &words(map.high));
}

/// Draws the names and levels of both factors.
fn names(svg: &mut Svg, map: &HeatMap<'_>, (left, bottom): (f64, f64), (width, rows): (f64, usize)) {
    for (column, level) in map.across.levels.iter().enumerate() {
        let x = left + width * (column as f64 + 0.5);
        svg.words((x, bottom + 20.0), 12.0, Anchor::Middle, SOFT, level);
    }
    for (row, level) in map.up.levels.iter().take(rows).enumerate() {
        let y = bottom - HEIGHT * (row as f64 + 0.5) + 4.0;
        svg.words((left - 10.0, y), 12.0, Anchor::End, SOFT, level);
    }
    let middle = left + 0.5 * width * map.across.levels.len() as f64;
    svg.words((middle, bottom + 44.0), 13.0, Anchor::Middle, PLAIN, map.across.name);
    let (x, y) = (20.0, f64::midpoint(TOP, bottom));
    svg.turned((x, y), 13.0, PLAIN, map.up.name);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(squares: &[Option<Square>]) -> String {
        heat_map(&HeatMap {
            is_less_better: false,
            across: Side {
                name: "noise <a>",
                levels: &["0.1", "0.2"],
            },
            up: Side {
                name: "size",
                levels: &["small", "large"],
            },
            value: "fitness",
            low: 1.0,
            high: 3.0,
            squares,
        })
    }

    const fn square(mean: f64, runs: usize) -> Square {
        Square { mean, runs }
    }

    #[test]
    fn every_square_has_its_number_and_empty_ones_say_so() {
        let text = map(&[
            Some(square(1.0, 1)),
            Some(square(3.0, 20)),
            None,
            Some(square(f64::NAN, 2)),
        ]);
        for words in [
            ">1<",
            ">1 run<",
            ">3<",
            ">20 runs<",
            ">no run<",
            ">no number<",
            ">2 runs<",
            "noise &lt;a&gt;",
        ] {
            assert!(text.contains(words), "{words}");
        }
        assert!(!text.contains("NaN"));
    }

    #[test]
    fn the_greatest_is_darkest_and_has_the_frame() {
        let text = map(&[Some(square(1.0, 1)), Some(square(3.0, 1)), Some(square(3.0, 1)), None]);
        assert_eq!(text.matches(FRAME).count(), 1);
        // The second square of the lower row.
        let frame = text.lines().find(|line| line.contains(FRAME)).expect("a frame");
        let left = 40.0 + label_room(["small"].into_iter()) + WIDTHS.1 + 2.0;
        assert!(
            frame.starts_with(&format!("<rect x=\"{left}\" y=\"{}\"", TOP + HEIGHT + 2.0)),
            "{frame}"
        );
        let dark = format!("fill=\"{}\" stroke", ramp(&HEAT, 1.0));
        assert_eq!(text.matches(&dark).count(), 2);
        assert!(!map(&[None, None, Some(square(f64::NAN, 1)), None]).contains(FRAME));
    }

    #[test]
    fn equal_values_have_one_shade() {
        let all = [Some(square(2.0, 1)); 4];
        let text = heat_map(&HeatMap {
            is_less_better: false,
            across: Side {
                name: "a",
                levels: &["1", "2"],
            },
            up: Side {
                name: "b",
                levels: &["1", "2"],
            },
            value: "v",
            low: 2.0,
            high: 2.0,
            squares: &all,
        });
        assert!(!text.contains("NaN") && text.matches(&format!("{}\" stroke", ramp(&HEAT, 0.5))).count() == 4);
    }
}
