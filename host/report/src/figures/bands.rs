//! Means of several runs and their spread, in panels side by side.

use super::plot::{LABEL_GAP, Plot, Range, label_room, label_style, letters_in, series};
use super::svg::{Anchor, BOLD, INK, PLAIN, SOFT, Svg};
use crate::numbers::Spread;

const WIDTH: f64 = 1060.0;
const HEIGHT: f64 = 400.0;
const LOWER: f64 = 300.0;
const LEFT: f64 = 74.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = 58.0;
/// Room to the right of a panel without names, in pixels.
const CLEAR: f64 = 16.0;
/// The largest part of a panel's width for names at its right, and where they begin above it.
const MOST_ROOM: f64 = 0.45;
const NAMES: f64 = 12.0;

/// A line and its spread.
pub struct Band<'a> {
    /// Name at its right end; empty for none.
    pub label: &'a str,
    pub colour: &'a str,
    /// Lengths of dashes and gaps; empty for a full line.
    pub dash: &'a str,
    /// Positions and values; means that aren't finite leave gaps.
    pub values: Vec<(f64, Spread)>,
}

/// Gives values evenly spaced positions from `first` on.
pub fn evenly(first: f64, spacing: f64, values: impl IntoIterator<Item = Spread>) -> Vec<(f64, Spread)> {
    let place = |(i, spread)| (first + spacing * f64::from(i), spread);
    (0_u32..).zip(values).map(place).collect()
}

/// A panel with its axes and its lines.
pub struct Panel<'a> {
    pub title: &'a str,
    /// Names of the axes, with their units.
    pub across: &'a str,
    pub up: &'a str,
    /// Range of positions shown.
    pub from: f64,
    pub to: f64,
    /// The vertical axis includes these values.
    pub low: f64,
    pub high: f64,
    /// Width relative to the other panels.
    pub share: f64,
    /// Position of a change, and labels of the times before and after it.
    pub change: Option<(f64, &'a str, &'a str)>,
    /// Meanings of dash patterns.
    pub key: &'a [(&'a str, &'a str)],
    /// Stripes of values with the same meaning; may be empty.
    pub grounds: &'a [Ground<'a>],
    pub bands: Vec<Band<'a>>,
}

impl Default for Panel<'_> {
    /// An empty panel with axes from 0 to 1.
    fn default() -> Self {
        Self {
            title: "",
            across: "",
            up: "",
            from: 0.0,
            to: 1.0,
            low: 0.0,
            high: 1.0,
            share: 1.0,
            change: None,
            key: &[],
            grounds: &[],
            bands: Vec::new(),
        }
    }
}

/// A stripe of values from `low` to `high` with the same meaning.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    pub low: f64,
    pub high: f64,
    /// Meaning, written to the right of the panel.
    pub label: &'a str,
    pub colour: &'a str,
}

/// Draws panels from left to right.
pub fn bands(title: &str, panels: &[Panel<'_>]) -> String {
    rows(title, &[panels], HEIGHT)
}

/// Draws rows of panels, each row lower than that of [`bands`].
pub fn grid(title: &str, panels: &[&[Panel<'_>]]) -> String {
    rows(title, panels, LOWER)
}

/// Draws one panel of a size in pixels.
pub fn panel(title: &str, panel: &Panel<'_>, (width, height): (f64, f64)) -> String {
    let mut svg = Svg::new(width, height, title);
    draw(&mut svg, panel, (0.0, width), (0.0, height));
    svg.finish()
}

fn rows(title: &str, rows: &[&[Panel<'_>]], height: f64) -> String {
    let mut svg = Svg::new(WIDTH, height * rows.len() as f64, title);
    let mut top = 0.0;
    for panels in rows {
        let shares: f64 = panels.iter().map(|panel| panel.share).sum();
        let mut left = 0.0;
        for panel in *panels {
            let width = panel.share / shares.max(f64::MIN_POSITIVE) * WIDTH;
            draw(&mut svg, panel, (left, left + width), (top, top + height));
            left += width;
        }
        top += height;
    }
    svg.finish()
}

/// Draws a panel between these edges.
pub(super) fn draw(svg: &mut Svg, panel: &Panel<'_>, (left, right): (f64, f64), (top, bottom): (f64, f64)) {
    let named = panel.bands.iter().any(|band| !band.label.is_empty());
    let room = if named || !panel.grounds.is_empty() {
        let names = panel.bands.iter().map(|band| band.label);
        label_room(names.chain(panel.grounds.iter().map(|ground| ground.label)))
    } else {
        CLEAR
    };
    let ends: Vec<(f64, &str, &str)> = panel
        .bands
        .iter()
        .filter(|band| !band.label.is_empty())
        .filter_map(|band| {
            let shown = values(panel, band);
            let last = shown.iter().rev().find(|(_, spread)| spread.mean.is_finite())?;
            Some((last.1.mean, band.label, band.colour))
        })
        .collect();
    // Names that would leave too little room to the lines are above them.
    let is_above = room > MOST_ROOM * (right - left) && panel.grounds.is_empty();
    let (room, above) = if is_above {
        (CLEAR, LABEL_GAP * ends.len() as f64)
    } else {
        (room, 0.0)
    };
    let plot = Plot {
        left: left + LEFT,
        right: right - room,
        top: top + TOP + above,
        bottom: bottom - BOTTOM,
        across: Range::between(panel.from, panel.to, if panel.share < 0.5 { 4 } else { 6 }),
        up: Range::around(panel.low, panel.high, 5),
    };
    let title = if is_above { left + NAMES } else { plot.left };
    svg.words((title, top + 24.0), 14.0, Anchor::Start, BOLD, panel.title);
    plot.begin(svg, panel.across, panel.up);
    grounds(svg, &plot, panel.grounds);
    if let Some((at, before, after)) = panel.change
        && (panel.from..=panel.to).contains(&at)
    {
        change(svg, &plot, at, before, after, panel.grounds.is_empty());
    }
    plot.axes(svg, panel.across, panel.up);
    let shown: Vec<Vec<(f64, Spread)>> = panel.bands.iter().map(|band| values(panel, band)).collect();
    for (band, values) in panel.bands.iter().zip(&shown) {
        for piece in values.split(|(_, spread)| !(spread.low + spread.high).is_finite()) {
            if piece.len() > 1 && piece.iter().any(|(_, spread)| spread.high > spread.low) {
                let above = piece.iter().map(|&(x, spread)| (plot.x(x), plot.y(spread.high)));
                let below = piece.iter().rev().map(|&(x, spread)| (plot.x(x), plot.y(spread.low)));
                let style = format!(
                    "fill=\"{}\" fill-opacity=\"0.16\" {}",
                    band.colour,
                    series(name(panel, band))
                );
                svg.polygon(above.chain(below), &style);
            }
        }
    }
    for (band, values) in panel.bands.iter().zip(&shown) {
        let values: Vec<(f64, f64)> = values.iter().map(|&(x, spread)| (x, spread.mean)).collect();
        let style = if band.dash.is_empty() {
            "stroke-width=\"2.2\"".to_owned()
        } else {
            format!("stroke-width=\"1.6\" stroke-dasharray=\"{}\"", band.dash)
        };
        plot.line(svg, &values, band.colour, &style, name(panel, band));
    }
    if is_above {
        for (place, (_, name, colour)) in ends.iter().enumerate() {
            let at = (left + NAMES, top + 24.0 + LABEL_GAP * (place + 1) as f64);
            let letters = letters_in(right - left - 2.0 * NAMES);
            let words = match name.char_indices().nth(letters) {
                Some((end, _)) => format!("{}\u{2026}", &name[..end]),
                None => (*name).to_owned(),
            };
            svg.words(at, 13.0, Anchor::Start, &label_style(colour, name), &words);
        }
    } else {
        plot.labels(svg, ends.into_iter());
    }
    key(svg, &plot, panel.key);
    if shown.iter().all(Vec::is_empty) {
        let middle = (0.5 * (plot.left + plot.right), 0.5 * (plot.top + plot.bottom));
        svg.words(middle, 13.0, Anchor::Middle, SOFT, "no data");
    }
    svg.raw("</g>");
}

/// A line's name: that at its end, or else the meaning of its dash pattern.
fn name<'a>(panel: &Panel<'a>, band: &Band<'a>) -> &'a str {
    let meaning = panel.key.iter().find(|(dash, _)| *dash == band.dash);
    match (band.label, meaning) {
        ("", Some((_, words))) => words,
        (label, _) => label,
    }
}

/// The values of a line that a panel shows.
fn values(panel: &Panel<'_>, band: &Band<'_>) -> Vec<(f64, Spread)> {
    let values = band.values.iter().copied();
    values.filter(|(x, _)| (panel.from..=panel.to).contains(x)).collect()
}

/// Draws stripes of values with their names.
fn grounds(svg: &mut Svg, plot: &Plot, grounds: &[Ground<'_>]) {
    for ground in grounds {
        let (low, high) = (plot.y(ground.low), plot.y(ground.high));
        let style = format!("fill=\"{}\"", ground.colour);
        svg.rectangle((plot.left, high), (plot.right - plot.left, low - high), &style);
        let at = (plot.right + 10.0, f64::midpoint(low, high) + 4.0);
        svg.words(at, 12.0, Anchor::Start, SOFT, ground.label);
    }
}

/// Draws a vertical line and, if `shaded`, a different background after it.
fn change(svg: &mut Svg, plot: &Plot, at: f64, before: &str, after: &str, shaded: bool) {
    let x = plot.x(at);
    if shaded {
        let size = (plot.right - x, plot.bottom - plot.top);
        svg.rectangle((x, plot.top), size, "fill=\"#fbf3dc\" data-x=\"\"");
    }
    let style = format!("stroke=\"{INK}\" stroke-width=\"1.2\" stroke-dasharray=\"2 3\" data-x=\"\"");
    svg.line((x, plot.top - 10.0), (x, plot.bottom), &style);
    let style = format!("{SOFT} data-x=\"\"");
    svg.words((x - 5.0, plot.top - 4.0), 11.0, Anchor::End, &style, before);
    svg.words((x + 5.0, plot.top - 4.0), 11.0, Anchor::Start, &style, after);
}

/// Draws the key to the dash patterns in the upper left corner.
fn key(svg: &mut Svg, plot: &Plot, entries: &[(&str, &str)]) {
    for (i, (dash, words)) in entries.iter().enumerate() {
        let (left, y) = (plot.left + 12.0, plot.top + 10.0 + 18.0 * i as f64);
        let style = format!("stroke=\"{INK}\" stroke-width=\"1.8\" stroke-dasharray=\"{dash}\"");
        svg.line((left, y), (left + 30.0, y), &style);
        svg.words((left + 38.0, y + 4.0), 12.0, Anchor::Start, PLAIN, words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel<'a>(values: &[[f64; 3]]) -> Panel<'a> {
        let values = values.iter().map(|&[low, mean, high]| Spread { low, mean, high });
        Panel {
            title: "a < b",
            across: "generation",
            up: "fitness",
            to: 3.0,
            high: 10.0,
            change: Some((2.0, "simulation", "reality")),
            key: &[("2 3", "again")],
            bands: vec![Band {
                label: "peak",
                colour: "#123456",
                dash: "",
                values: evenly(0.0, 1.0, values),
            }],
            ..Panel::default()
        }
    }

    #[test]
    fn a_band_runs_up_along_its_highs_and_back_along_its_lows() {
        let text = bands("t", &[panel(&[[0.0, 5.0, 10.0], [0.0, 5.0, 10.0]])]);
        let shape = text.lines().find(|line| line.starts_with("<polygon")).expect("a band");
        let points: Vec<&str> = shape.split('"').nth(1).unwrap_or_default().split(' ').collect();
        assert_eq!(points.len(), 4);
        assert!(points[0].ends_with(",52") && points[1].ends_with(",52"), "{points:?}");
        assert!(points[2].ends_with(",342") && points[3].ends_with(",342"), "{points:?}");
    }

    /// Names take no more than a part of the width, so that lines have room.
    #[test]
    fn long_names_stand_above_a_narrow_panel() {
        let drawn = |label| {
            let mut own = panel(&[[1.0; 3]; 3]);
            own.bands[0].label = label;
            super::panel("t", &own, (320.0, 340.0))
        };
        let right = |text: &str| -> f64 {
            let plot = text.split("data-plot=\"").nth(1).unwrap();
            plot.split(' ').nth(1).unwrap().parse().unwrap()
        };
        assert_eq!(right(&drawn("short")), 320.0 - label_room(["short"].into_iter()));
        let long = drawn("evolution.generations 200, noise.motor 0.3");
        assert_eq!(right(&long), 320.0 - CLEAR);
        let name = long
            .lines()
            .find(|line| line.contains(">evolution.generations"))
            .unwrap();
        assert!(
            name.contains("x=\"12\" y=\"41\"") && name.contains("data-series="),
            "{name}"
        );
        assert!(drawn(&"long ".repeat(20)).contains("lon\u{2026}</text>"));
    }

    #[test]
    fn only_what_the_panel_spans_is_drawn() {
        let mut zoomed = panel(&[[1.0; 3]; 9]);
        assert_eq!(values(&zoomed, &zoomed.bands[0]).len(), 4);
        zoomed.from = 2.0;
        assert_eq!(values(&zoomed, &zoomed.bands[0]).len(), 2);
    }

    #[test]
    fn without_spread_there_is_no_band_and_without_values_no_line() {
        let text = bands("t", &[panel(&[[3.0; 3], [4.0; 3]])]);
        assert_eq!(
            (text.matches("<polygon").count(), text.matches("<polyline").count()),
            (0, 1)
        );
        let text = bands("t", &[panel(&[])]);
        assert_eq!(text.matches("<polyline").count(), 0);
        assert!(text.contains(">no data<") && text.contains("a &lt; b"));
    }

    #[test]
    fn a_gap_parts_band_and_line() {
        let gap = [f64::NAN; 3];
        let text = bands(
            "t",
            &[Panel {
                to: 4.0,
                ..panel(&[[0.0, 1.0, 2.0], [0.0, 1.0, 2.0], gap, [0.0, 1.0, 2.0], [0.0, 1.0, 2.0]])
            }],
        );
        assert_eq!(
            (text.matches("<polygon").count(), text.matches("<polyline").count()),
            (2, 2)
        );
        assert!(!text.contains("NaN"));
    }

    #[test]
    fn stripes_lie_behind_all_rows_below_each_other() {
        let grounds = [Ground {
            low: 0.0,
            high: 5.0,
            label: "low < high",
            colour: "#abcdef",
        }];
        let striped = || Panel {
            grounds: &grounds,
            ..panel(&[[1.0; 3]; 3])
        };
        let text = grid("t", &[&[striped()], &[striped()]]);
        assert_eq!(text.matches("low &lt; high").count(), 2);
        // Half of a plot from 52 to 242, and the same one row lower; a change has no separate background.
        assert!(text.contains("y=\"147\"") && text.contains("y=\"447\"") && text.contains("height=\"95\""));
        assert!(!text.contains("#fbf3dc"));
    }

    #[test]
    fn a_change_is_marked_if_the_panel_spans_it() {
        let marked = |at| {
            let change = Some((at, "simulation", "reality"));
            bands(
                "t",
                &[Panel {
                    change,
                    ..panel(&[[1.0; 3]; 3])
                }],
            )
            .contains("reality")
        };
        assert!(marked(3.0) && !marked(3.5) && !marked(-1.0));
    }
}
