//! Values over generations.

use super::plot::{EPISODES, Plot, Range, label_room};
use super::svg::{Anchor, BOLD, Svg};

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 56.0;
/// Colours of the lines, in order: dark enough for their names.
const COLOURS: [&str; 5] = ["#c8374f", "#2b3a8f", "#17796d", "#a06500", "#8a3fa0"];

/// A line of a figure: one value for each generation from 0 on.
pub struct Series<'a> {
    /// Name of the line.
    pub label: &'a str,
    /// Values; one that isn't finite leaves a gap.
    pub values: Vec<f64>,
}

/// Draws lines over generations, each with its name at its right end. A page's reader may choose episodes instead: `spent` has those of
/// the first generation, of the first two, and so on.
pub fn learning_curve(title: &str, value: &str, series: &[Series<'_>], spent: Option<&[u64]>) -> String {
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.words((LEFT, 28.0), 16.0, Anchor::Start, BOLD, title);
    let Some(spent) = spent else {
        draw(&mut svg, ("generation", value), series, |generation| generation as f64);
        return svg.finish();
    };
    let after = |generation: usize| spent.get(generation).map_or(f64::NAN, |episodes| *episodes as f64);
    svg.choices(&["generation", EPISODES], |svg, place| match place {
        0 => draw(svg, ("generation", value), series, |generation| generation as f64),
        _ => draw(svg, (EPISODES, value), series, after),
    });
    svg.finish()
}

/// Draws lines whose values have these places across.
fn draw(svg: &mut Svg, (across, up): (&str, &str), series: &[Series<'_>], at: impl Fn(usize) -> f64) {
    let plot = plot(series, &at);
    plot.begin(svg, across, up);
    plot.axes(svg, across, up);
    for (line, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        let values: Vec<(f64, f64)> = line.values.iter().enumerate().map(|(i, &y)| (at(i), y)).collect();
        plot.line(svg, &values, colour, "stroke-width=\"2.2\"", line.label);
    }
    let ends = series.iter().zip(COLOURS.iter().cycle()).filter_map(|(line, &colour)| {
        let last = line.values.iter().rev().find(|value| value.is_finite())?;
        Some((*last, line.label, colour))
    });
    plot.labels(svg, ends);
    svg.raw("</g>");
}

/// A plot with room for all values and names.
fn plot(series: &[Series<'_>], at: &impl Fn(usize) -> f64) -> Plot {
    let longest = series.iter().map(|line| line.values.len()).max().unwrap_or(0);
    let last = at(longest.saturating_sub(1)).max(1.0);
    Plot {
        left: LEFT,
        right: WIDTH - label_room(series.iter().map(|line| line.label)),
        top: TOP,
        bottom: HEIGHT - BOTTOM,
        across: Range {
            step: Range::between(0.0, last, 8).step.max(1.0),
            ..Range::between(0.0, last, 8)
        },
        up: Range::holding(series.iter().flat_map(|line| line.values.iter().copied()), 5),
    }
}

#[cfg(test)]
mod tests {
    use super::super::plot::LABEL_GAP;
    use super::*;

    #[test]
    fn values_keep_their_order_on_the_sheet() {
        let series = [Series {
            label: "best",
            values: vec![-3.0, 120.0, 480.0],
        }];
        let plot = plot(&series, &|generation| generation as f64);
        assert!(plot.y(480.0) < plot.y(120.0) && plot.y(120.0) < plot.y(-3.0));
        assert!(plot.y(480.0) >= TOP && plot.y(-3.0) <= HEIGHT - BOTTOM);
    }

    #[test]
    fn labels_do_not_overlap() {
        let series: Vec<_> = ["a", "b", "c"]
            .into_iter()
            .map(|label| Series {
                label,
                values: vec![0.0, 0.0],
            })
            .collect();
        let text = learning_curve("t", "fitness", &series, None);
        let mut heights: Vec<f64> = text
            .lines()
            .filter(|line| line.contains("font-weight=\"600\"") && !line.contains(">t<"))
            .filter_map(|line| line.split("y=\"").nth(1)?.split('"').next()?.parse().ok())
            .collect();
        heights.sort_by(f64::total_cmp);
        assert_eq!(heights.len(), 3, "{text}");
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] >= LABEL_GAP));
    }

    #[test]
    fn gaps_and_empty_series_are_drawn_as_such() {
        let series = [
            Series {
                label: "a",
                values: vec![1.0, f64::NAN, 2.0, 3.0],
            },
            Series {
                label: "b",
                values: vec![],
            },
        ];
        let text = learning_curve("t", "fitness", &series, None);
        assert_eq!(text.matches("<polyline").count(), 1);
        assert_eq!(text.matches("<circle").count(), 1);
        assert!(!text.contains("NaN"));
    }
}
