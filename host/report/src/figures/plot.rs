//! A coordinate system with axes, and lines in it.

use super::svg::{Anchor, PLAIN, SOFT, SOFT_INK, Svg, escaped, number, tick_step};
use crate::numbers::fixed;

/// Name of an axis of episodes.
pub const EPISODES: &str = "episodes spent";
/// Minimum distance of two labels, in pixels.
pub const LABEL_GAP: f64 = 17.0;
/// Approximate width of a letter of a label, in pixels.
const LETTER: f64 = 7.6;

/// Range of an axis.
pub struct Range {
    pub low: f64,
    pub high: f64,
    pub step: f64,
}

impl Range {
    /// A range from one value to another, with about `count` ticks.
    pub fn between(low: f64, high: f64, count: u32) -> Self {
        let high = if high > low { high } else { low + 1.0 };
        Self {
            low,
            high,
            step: tick_step(high - low, count),
        }
    }

    /// A range that contains 0 and all finite values and ends with a tick at the top.
    pub fn holding(values: impl Iterator<Item = f64>, count: u32) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((0.0, 0.0), |(low, high): (f64, f64), value| {
                (low.min(value), high.max(value))
            });
        let Self { low, high, step } = Self::between(low, high, count);
        Self {
            // Values slightly below 0 don't get a whole step of height.
            low: low - if low < 0.0 { 0.1 * step } else { 0.0 },
            high: (high / step).ceil() * step,
            step,
        }
    }

    /// A range that contains both values and everything between, and 0 unless both are farther from it than from each
    /// other. It begins and ends with a tick, except slightly below 0.
    pub fn around(low: f64, high: f64, count: u32) -> Self {
        let nearest = if low > 0.0 { low } else { -high };
        if nearest <= high - low || !(high - low).is_finite() {
            return Self::holding([low, high].into_iter(), count);
        }
        // A constant value gets room on both sides.
        let room = if high > low { 0.0 } else { 0.05 * nearest };
        let step = tick_step(high - low + 2.0 * room, count);
        Self {
            low: ((low - room) / step).floor() * step,
            high: ((high + room) / step).ceil() * step,
            step,
        }
    }

    /// Formats a tick with as many decimals as the step needs, and with two if it needs none.
    pub fn words(&self, tick: f64) -> String {
        let mut decimals = 2;
        while decimals < 12 && self.step * 10_f64.powi(decimals) < 0.999 {
            decimals += 1;
        }
        if decimals == 2 {
            return number(tick);
        }
        let text = fixed(tick, decimals as usize);
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Multiples of the step.
    pub fn ticks(&self) -> impl Iterator<Item = f64> {
        let step = self.step;
        let first = (self.low / step).ceil();
        let count = ((self.high / step + 1e-9).floor() - first).clamp(0.0, 100.0) as u32;
        (0..=count).map(move |i| (first + f64::from(i)) * step)
    }
}

/// Mapping from values to pixels: the plot's edges and the ranges between them.
pub struct Plot {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub across: Range,
    pub up: Range,
}

impl Plot {
    pub fn x(&self, value: f64) -> f64 {
        self.left + self.across.share(value) * (self.right - self.left)
    }

    pub fn y(&self, value: f64) -> f64 {
        self.bottom - self.up.share(value) * (self.bottom - self.top)
    }

    /// Begins the group of a plot with lines, up to its end tag `</g>`. Its attributes tell a page's script, `svg-chart.js`, the
    /// plot's edges in pixels, the ranges between them, and the axes' names. Lines, bands and their labels have
    /// their series in `data-series`, ticks across in `data-tick`, and whatever else has a place across in `data-x`.
    pub fn begin(&self, svg: &mut Svg, across: &str, up: &str) {
        let [left, right, top, bottom] = [self.left, self.right, self.top, self.bottom].map(number);
        let (
            Range { low, high, .. },
            Range {
                low: least, high: most, ..
            },
        ) = (&self.across, &self.up);
        svg.raw(&format!(
            "<g data-plot=\"{left} {right} {top} {bottom}\" data-across=\"{low} {high}\" data-up=\"{least} {most}\" \
             data-names=\"{}|{}\">",
            escaped(across),
            escaped(up),
        ));
    }

    /// Draws both axes with their names.
    pub fn axes(&self, svg: &mut Svg, across: &str, up: &str) {
        self.ground(svg, up);
        for tick in self.across.ticks() {
            self.tick(svg, tick, &self.across.words(tick));
        }
        let at = (0.5 * (self.left + self.right), self.bottom + 42.0);
        svg.words(at, 13.0, Anchor::Middle, PLAIN, across);
    }

    /// Draws a tick of the horizontal axis with its name.
    pub fn tick(&self, svg: &mut Svg, at: f64, name: &str) {
        let (x, bottom) = (self.x(at), self.bottom);
        let style = format!("stroke=\"{SOFT_INK}\" data-tick=\"\"");
        svg.line((x, bottom), (x, bottom + 5.0), &style);
        svg.words(
            (x, bottom + 20.0),
            12.0,
            Anchor::Middle,
            &format!("{SOFT} data-tick=\"\""),
            name,
        );
    }

    /// Draws the vertical axis with its name, and the base line of the horizontal one.
    pub fn ground(&self, svg: &mut Svg, up: &str) {
        let &Self {
            left,
            right,
            top,
            bottom,
            ..
        } = self;
        for tick in self.up.ticks() {
            let y = self.y(tick);
            svg.line((left, y), (right, y), "stroke=\"#e4e5e8\" stroke-width=\"1\"");
            svg.words((left - 8.0, y + 4.0), 12.0, Anchor::End, SOFT, &self.up.words(tick));
        }
        svg.line(
            (left, bottom),
            (right, bottom),
            &format!("stroke=\"{SOFT_INK}\" stroke-width=\"1.2\""),
        );
        // Clear of the longest number.
        let digits = self.up.ticks().map(|tick| self.up.words(tick).len()).max().unwrap_or(0);
        let x = left - (18.0 + 7.0 * digits as f64).max(46.0);
        svg.turned((x, 0.5 * (top + bottom)), 13.0, PLAIN, up);
    }

    /// Draws a line through values, with gaps for values that aren't finite. An isolated value becomes a dot with its
    /// name as a tooltip.
    pub fn line(&self, svg: &mut Svg, values: &[(f64, f64)], colour: &str, style: &str, name: &str) {
        let series = series(name);
        let style = format!("stroke=\"{colour}\" stroke-linejoin=\"round\" stroke-linecap=\"round\" {style} {series}");
        for piece in values.split(|(_, value)| !value.is_finite()) {
            match piece {
                [] => {}
                [(x, value)] => svg.circle(
                    (self.x(*x), self.y(*value)),
                    2.5,
                    &format!("fill=\"{colour}\" {series}"),
                    name,
                ),
                _ => svg.polyline(piece.iter().map(|&(x, value)| (self.x(x), self.y(value))), &style),
            }
        }
    }

    /// Draws names at the right ends of lines, moved apart to avoid overlaps. `ends` has the lines' last values, names
    /// and colours.
    pub fn labels<'a>(&self, svg: &mut Svg, ends: impl Iterator<Item = (f64, &'a str, &'a str)>) {
        let mut labels: Vec<(f64, &str, &str)> = ends
            .map(|(value, name, colour)| (self.y(value), name, colour))
            .collect();
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        for i in 1..labels.len() {
            labels[i].0 = labels[i].0.max(labels[i - 1].0 + LABEL_GAP);
        }
        let too_low = labels.last().map_or(0.0, |label| (label.0 - self.bottom).max(0.0));
        for (y, name, colour) in labels {
            svg.words(
                (self.right + 10.0, y - too_low + 4.0),
                13.0,
                Anchor::Start,
                &label_style(colour, name),
                name,
            );
        }
    }
}

/// The style of a line's name.
pub fn label_style(colour: &str, name: &str) -> String {
    format!("fill=\"{colour}\" font-weight=\"600\" {}", series(name))
}

/// The attribute of what belongs to a series.
pub fn series(name: &str) -> String {
    format!("data-series=\"{}\"", escaped(name))
}

/// Room that names take to the right of a plot.
pub fn label_room<'a>(names: impl Iterator<Item = &'a str>) -> f64 {
    let letters = names.map(|name| name.chars().count()).max().unwrap_or(0);
    26.0 + LETTER * letters as f64
}

/// Letters of a name that fit into a room.
pub fn letters_in(room: f64) -> usize {
    (room / LETTER) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_reach_both_ends() {
        let range = Range::between(0.0, 500.0, 5);
        assert_eq!(
            range.ticks().collect::<Vec<_>>(),
            [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]
        );
        assert_eq!(Range::between(-1.0, 1.0, 4).ticks().count(), 5);
    }

    #[test]
    fn ranges_hold_what_they_show() {
        let range = Range::holding([-3.0, f64::NAN, 120.0, 480.0].into_iter(), 5);
        assert!(range.low <= -3.0 && range.high >= 480.0);
        let nothing = Range::holding([].into_iter(), 5);
        assert!(nothing.low == 0.0 && nothing.high > 0.0 && nothing.step > 0.0);
    }

    #[test]
    fn nothing_is_in_a_range_only_where_values_are_near_it() {
        let ends = |low, high| {
            let range = Range::around(low, high, 5);
            (range.low, range.high)
        };
        assert_eq!(ends(0.0, 480.0), (0.0, 500.0));
        assert_eq!(ends(150.0, 480.0), (0.0, 500.0));
        assert_eq!(ends(430.0, 480.0), (430.0, 480.0));
        assert_eq!(ends(-480.0, -431.0), (-480.0, -430.0));
        assert_eq!(ends(512.0, 512.0), (480.0, 540.0));
        assert_eq!(ends(f64::NAN, 2.0), (0.0, 2.0));
    }

    #[test]
    fn ticks_have_the_decimals_of_their_step() {
        let words = |high: f64| {
            let range = Range::between(0.0, high, 5);
            range.ticks().map(|tick| range.words(tick)).collect::<Vec<_>>()
        };
        assert_eq!(words(0.004), ["0", "0.001", "0.002", "0.003", "0.004"]);
        assert_eq!(words(0.5), ["0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(words(1e6), ["0", "200000", "400000", "600000", "800000", "1000000"]);
    }

    #[test]
    fn values_keep_their_order_on_the_sheet() {
        let plot = Plot {
            left: 10.0,
            right: 110.0,
            top: 20.0,
            bottom: 220.0,
            across: Range::between(0.0, 2.0, 2),
            up: Range::between(-10.0, 10.0, 2),
        };
        assert_eq!((plot.x(0.0), plot.x(1.0), plot.x(2.0)), (10.0, 60.0, 110.0));
        assert_eq!((plot.y(-10.0), plot.y(0.0), plot.y(10.0)), (220.0, 120.0, 20.0));
    }
}
