//! Values over generations.

use super::svg::{Anchor, INK, SOFT_INK, Svg, number, tick_step};

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 64.0;
/// Of a letter of a label, about; labels stand to the right of the plot.
const LETTER: f64 = 7.6;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 56.0;
/// Colours of the lines, in their order.
const COLOURS: [&str; 5] = ["#d9485f", "#2b3a8f", "#2a9d8f", "#f4a23b", "#8a3fa0"];
/// Least distance of two labels, in pixels.
const LABEL_GAP: f64 = 17.0;

/// One line of a figure: a value for each generation from 0 on.
pub(crate) struct Series<'a> {
    /// What it shows.
    pub(crate) label: &'a str,
    /// Its values; one that is not finite leaves a gap.
    pub(crate) values: Vec<f64>,
}

/// Lines over generations, each named at its right end.
pub(crate) fn learning_curve(title: &str, value: &str, series: &[Series<'_>]) -> String {
    let plot = Plot::new(series);
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.words(
        (LEFT, 28.0),
        16.0,
        Anchor::Start,
        &format!("fill=\"{INK}\" font-weight=\"600\""),
        title,
    );
    plot.axes(&mut svg, value);
    for (line, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        plot.line(&mut svg, line, colour);
    }
    plot.labels(&mut svg, series);
    svg.finish()
}

/// How values become pixels.
struct Plot {
    /// Room for the labels.
    right: f64,
    generations: f64,
    low: f64,
    high: f64,
    step: f64,
}

impl Plot {
    /// Holds all values, and 0.
    fn new(series: &[Series<'_>]) -> Self {
        let values = || {
            series
                .iter()
                .flat_map(|line| &line.values)
                .copied()
                .filter(|value| value.is_finite())
        };
        let low = values().fold(0.0, f64::min);
        let high = values().fold(0.0, f64::max);
        let high = if high > low { high } else { low + 1.0 };
        let step = tick_step(high - low, 5);
        let generations = series
            .iter()
            .map(|line| line.values.len())
            .max()
            .unwrap_or(0)
            .saturating_sub(1)
            .max(1);
        let letters = series.iter().map(|line| line.label.chars().count()).max().unwrap_or(0);
        Self {
            right: 26.0 + LETTER * letters as f64,
            generations: generations as f64,
            // A little below nothing shall not cost a whole step of height.
            low: low - if low < 0.0 { 0.1 * step } else { 0.0 },
            high: (high / step).ceil() * step,
            step,
        }
    }

    fn x(&self, generation: f64) -> f64 {
        LEFT + generation / self.generations * (WIDTH - LEFT - self.right)
    }

    fn y(&self, value: f64) -> f64 {
        HEIGHT - BOTTOM - (value - self.low) / (self.high - self.low) * (HEIGHT - TOP - BOTTOM)
    }

    fn axes(&self, svg: &mut Svg, value: &str) {
        let (right, bottom) = (WIDTH - self.right, HEIGHT - BOTTOM);
        let words = format!("fill=\"{SOFT_INK}\"");
        for tick in ticks(self.low, self.high, self.step) {
            let y = self.y(tick);
            svg.line((LEFT, y), (right, y), "stroke=\"#e4e5e8\" stroke-width=\"1\"");
            svg.words((LEFT - 8.0, y + 4.0), 12.0, Anchor::End, &words, &number(tick));
        }
        let step = tick_step(self.generations, 8).max(1.0);
        for tick in ticks(0.0, self.generations, step) {
            let x = self.x(tick);
            svg.line((x, bottom), (x, bottom + 5.0), &format!("stroke=\"{SOFT_INK}\""));
            svg.words((x, bottom + 20.0), 12.0, Anchor::Middle, &words, &number(tick));
        }
        svg.line(
            (LEFT, bottom),
            (right, bottom),
            &format!("stroke=\"{SOFT_INK}\" stroke-width=\"1.2\""),
        );
        let ink = format!("fill=\"{INK}\"");
        svg.words(
            (0.5 * (LEFT + right), HEIGHT - 14.0),
            13.0,
            Anchor::Middle,
            &ink,
            "generation",
        );
        let middle = 0.5 * (TOP + bottom);
        let turned = format!("{ink} transform=\"rotate(-90 18 {})\"", number(middle));
        svg.words((18.0, middle), 13.0, Anchor::Middle, &turned, value);
    }

    fn line(&self, svg: &mut Svg, line: &Series<'_>, colour: &str) {
        let style =
            format!("stroke=\"{colour}\" stroke-width=\"2.2\" stroke-linejoin=\"round\" stroke-linecap=\"round\"");
        let points: Vec<(f64, f64)> = line
            .values
            .iter()
            .enumerate()
            .map(|(i, &value)| (self.x(i as f64), value))
            .collect();
        for piece in points.split(|(_, value)| !value.is_finite()) {
            match piece {
                [] => {}
                [(x, value)] => svg.circle((*x, self.y(*value)), 2.5, &format!("fill=\"{colour}\""), line.label),
                _ => svg.polyline(piece.iter().map(|&(x, value)| (x, self.y(value))), &style),
            }
        }
    }

    /// Names at the right end of each line, moved apart where they would overlap.
    fn labels(&self, svg: &mut Svg, series: &[Series<'_>]) {
        let mut labels: Vec<(f64, &str, &str)> = series
            .iter()
            .zip(COLOURS.iter().cycle())
            .filter_map(|(line, &colour)| {
                let last = line.values.iter().rev().find(|value| value.is_finite())?;
                Some((self.y(*last), line.label, colour))
            })
            .collect();
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        for i in 1..labels.len() {
            labels[i].0 = labels[i].0.max(labels[i - 1].0 + LABEL_GAP);
        }
        let too_low = labels
            .last()
            .map_or(0.0, |label| (label.0 - (HEIGHT - BOTTOM)).max(0.0));
        for (y, label, colour) in labels {
            let at = (WIDTH - self.right + 10.0, y - too_low + 4.0);
            svg.words(
                at,
                13.0,
                Anchor::Start,
                &format!("fill=\"{colour}\" font-weight=\"600\""),
                label,
            );
        }
    }
}

/// Multiples of a step from one value to another.
fn ticks(from: f64, to: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (from / step).ceil();
    let count = ((to / step + 1e-9).floor() - first).clamp(0.0, 100.0) as u32;
    (0..=count).map(move |i| (first + f64::from(i)) * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_reach_both_ends() {
        assert_eq!(
            ticks(0.0, 500.0, 100.0).collect::<Vec<_>>(),
            [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]
        );
        assert_eq!(ticks(-1.0, 1.0, 0.5).count(), 5);
    }

    #[test]
    fn values_keep_their_order_on_the_sheet() {
        let series = [Series {
            label: "best",
            values: vec![-3.0, 120.0, 480.0],
        }];
        let plot = Plot::new(&series);
        assert!(plot.low <= -3.0 && plot.high >= 480.0);
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
        let text = learning_curve("t", "fitness", &series);
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
        let text = learning_curve("t", "fitness", &series);
        assert_eq!(text.matches("<polyline").count(), 1);
        assert_eq!(text.matches("<circle").count(), 1);
        assert!(!text.contains("NaN"));
    }
}
