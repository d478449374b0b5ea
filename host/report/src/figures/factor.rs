//! Effect of a factor: on the left the curves of its levels, on the right their outcomes.

use super::bands::{Panel, draw};
use super::plot::{Plot, Range};
use super::svg::{Anchor, BOLD, INK, PLAIN, SOFT, Svg, ramp};
use crate::numbers::{Digits, Spread, in_figure};

const WIDTH: f64 = 1060.0;
const HEIGHT: f64 = 380.0;
/// Left edge of the right panel.
const MIDDLE: f64 = 600.0;
const LEFT: f64 = 74.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = 58.0;
const RIGHT: f64 = 20.0;
/// Approximate width of a letter of a tick's name.
const LETTER: f64 = 6.8;
/// Minimum and maximum half-width of the drawing at a level.
const HALF: (f64, f64) = (3.0, 24.0);
/// Colours of ordered levels from the lowest to the highest: dark enough for letters, light enough to differ from
/// black.
const ORDERED: [[u8; 3]; 4] = [
    [0xa0, 0x65, 0x00],
    [0xc8, 0x37, 0x4f],
    [0x7a, 0x35, 0x9a],
    [0x1f, 0x2d, 0x7a],
];
/// Colours of unordered levels.
const UNORDERED: [&str; 6] = ["#2b3a8f", "#c8374f", "#17796d", "#a06500", "#8a3fa0", "#6b6e76"];
/// Dash patterns that distinguish lines of neighbouring levels in print without colours.
const DASHES: [&str; 3] = ["", "8 4", "2.5 3.5"];

/// Axis of a factor's levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Names side by side, at positions 0, 1, 2 and so on.
    Names,
    /// A linear axis of numbers.
    Linear,
    /// A logarithmic axis of positive numbers.
    Logarithmic,
}

/// Outcomes at one level, or at several neighbouring ones.
pub struct Column<'a> {
    pub label: &'a str,
    pub colour: &'a str,
    /// Positions of its first and last level; equal for a single level.
    pub from: f64,
    pub to: f64,
    /// The mean and its interval.
    pub mean: Spread,
    /// Minimum, quartiles and maximum, to be drawn as a box.
    pub quartiles: Option<[f64; 5]>,
    /// Positions and values, to be drawn as points.
    pub points: Vec<(f64, f64)>,
}

/// Outcomes at all levels.
pub struct Outcomes<'a> {
    pub title: &'a str,
    /// Names of the axes, with their units.
    pub across: &'a str,
    pub up: &'a str,
    pub scale: Scale,
    pub columns: &'a [Column<'a>],
}

/// Colours and dash patterns of `count` levels.
pub fn level_styles(count: usize, is_ordered: bool) -> Vec<(String, &'static str)> {
    let colour = |level: usize| {
        if is_ordered && count > 1 {
            ramp(&ORDERED, level as f64 / (count - 1) as f64)
        } else {
            UNORDERED[level % UNORDERED.len()].to_owned()
        }
    };
    let style = |level: usize| (colour(level), DASHES[level % DASHES.len()]);
    (0..count).map(style).collect()
}

/// Draws both panels. If there are several of curves, a page's reader may choose by their axes across.
pub fn factor(title: &str, curves: &[Panel<'_>], outcomes: &Outcomes<'_>) -> String {
    let names = Names::of(outcomes);
    let mut svg = Svg::new(WIDTH, HEIGHT + names.room, title);
    let panel = |svg: &mut Svg, place: usize| draw(svg, &curves[place], (0.0, MIDDLE), (0.0, HEIGHT));
    match curves {
        [_] => panel(&mut svg, 0),
        _ => svg.choices(&curves.iter().map(|own| own.across).collect::<Vec<_>>(), panel),
    }
    levels(&mut svg, outcomes, &names);
    svg.finish()
}

/// Names of levels under the right panel.
struct Names {
    /// Positions and names.
    ticks: Vec<(f64, String)>,
    /// Whether the names are slanted because they don't fit side by side.
    askew: bool,
    /// Room that the names need below the axis, in pixels.
    room: f64,
}

impl Names {
    fn of(outcomes: &Outcomes<'_>) -> Self {
        let columns = outcomes.columns;
        let longest = columns
            .iter()
            .map(|column| column.label.chars().count())
            .max()
            .unwrap_or(0);
        let wide = LETTER * longest as f64 + 6.0;
        let slot = (WIDTH - RIGHT - MIDDLE - LEFT) / columns.len().max(1) as f64;
        let askew = outcomes.scale == Scale::Names && wide > slot;
        let ticks = if columns.iter().any(|column| column.to > column.from) {
            Vec::new()
        } else {
            let tick = |column: &Column<'_>| (column.from, column.label.to_owned());
            columns.iter().map(tick).collect()
        };
        Self {
            ticks,
            askew,
            room: if askew { (0.57 * wide - 8.0).max(0.0) } else { 0.0 },
        }
    }
}

/// Position on the axis.
fn place(scale: Scale, x: f64) -> f64 {
    if scale == Scale::Logarithmic { x.log10() } else { x }
}

/// The coordinate system of the right panel.
fn plane(outcomes: &Outcomes<'_>) -> Plot {
    let columns = outcomes.columns;
    let places = columns.iter().flat_map(|column| [column.from, column.to]);
    let (low, high) = ends(places.map(|x| place(outcomes.scale, x))).unwrap_or((0.0, 1.0));
    let margin = match outcomes.scale {
        Scale::Names => 0.5,
        _ if high > low => 0.09 * (high - low),
        _ => 0.5,
    };
    let values = columns.iter().flat_map(|column| {
        let points = column.points.iter().map(|(_, y)| *y);
        let quartiles = column.quartiles.into_iter().flatten();
        points.chain(quartiles).chain([column.mean.low, column.mean.high])
    });
    let (least, greatest) = ends(values).unwrap_or((0.0, 1.0));
    Plot {
        left: MIDDLE + LEFT,
        right: WIDTH - RIGHT,
        top: TOP,
        bottom: HEIGHT - BOTTOM,
        across: Range::between(low - margin, high + margin, 5),
        up: Range::around(least, greatest, 5),
    }
}

/// Minimum and maximum of the finite values.
fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut ends: Option<(f64, f64)> = None;
    for value in values.filter(|value| value.is_finite()) {
        let (low, high) = ends.unwrap_or((value, value));
        ends = Some((low.min(value), high.max(value)));
    }
    ends
}

fn levels(svg: &mut Svg, outcomes: &Outcomes<'_>, names: &Names) {
    let plot = plane(outcomes);
    svg.words((plot.left, TOP - 28.0), 14.0, Anchor::Start, BOLD, outcomes.title);
    plot.ground(svg, outcomes.up);
    axis(svg, outcomes, names, &plot);
    let half = half_width(outcomes, &plot);
    for column in outcomes.columns {
        let edges = edges(outcomes.scale, column, &plot, half);
        if let Some(quartiles) = column.quartiles {
            quartile_box(svg, &plot, column.colour, edges, quartiles);
        }
        points(svg, &plot, outcomes.scale, column, half);
    }
    for column in outcomes.columns {
        mean(svg, &plot, column, edges(outcomes.scale, column, &plot, half));
    }
    if outcomes.columns.iter().all(|column| !column.mean.mean.is_finite()) {
        let middle = (0.5 * (plot.left + plot.right), 0.5 * (plot.top + plot.bottom));
        svg.words(middle, 13.0, Anchor::Middle, SOFT, "no data");
    }
}

/// Half-width of the drawing at a level, which keeps clear of its neighbours.
fn half_width(outcomes: &Outcomes<'_>, plot: &Plot) -> f64 {
    let at = outcomes
        .columns
        .iter()
        .map(|column| plot.x(place(outcomes.scale, column.from)));
    let mut at: Vec<f64> = at.collect();
    at.sort_by(f64::total_cmp);
    let gaps = at.windows(2).map(|pair| pair[1] - pair[0]);
    (0.36 * gaps.fold(f64::INFINITY, f64::min)).clamp(HALF.0, HALF.1)
}

/// Left and right edge of a column in pixels.
fn edges(scale: Scale, column: &Column<'_>, plot: &Plot, half: f64) -> (f64, f64) {
    let (from, to) = (plot.x(place(scale, column.from)), plot.x(place(scale, column.to)));
    if to > from {
        (from, to)
    } else {
        (from - half, from + half)
    }
}

/// Draws the horizontal axis.
fn axis(svg: &mut Svg, outcomes: &Outcomes<'_>, names: &Names, plot: &Plot) {
    if !names.ticks.is_empty() {
        if names.askew {
            askew(svg, plot, &names.ticks);
        } else {
            apart(
                svg,
                plot,
                names
                    .ticks
                    .iter()
                    .map(|(x, name)| (place(outcomes.scale, *x), name.as_str())),
            );
        }
    } else if outcomes.scale == Scale::Logarithmic {
        let ticks = decades(&plot.across);
        apart(svg, plot, ticks.iter().map(|(x, name)| (*x, name.as_str())));
    } else {
        for tick in plot.across.ticks() {
            plot.tick(svg, tick, &plot.across.words(tick));
        }
    }
    let at = (0.5 * (plot.left + plot.right), HEIGHT + names.room - 16.0);
    svg.words(at, 13.0, Anchor::Middle, PLAIN, outcomes.across);
}

/// Draws ticks, leaving out names that would overlap the one before.
fn apart<'a>(svg: &mut Svg, plot: &Plot, ticks: impl Iterator<Item = (f64, &'a str)>) {
    let mut clear = f64::NEG_INFINITY;
    for (at, name) in ticks {
        let half = 0.5 * LETTER * name.chars().count() as f64;
        let has_room = plot.x(at) - half >= clear;
        plot.tick(svg, at, if has_room { name } else { "" });
        if has_room {
            clear = plot.x(at) + half + 4.0;
        }
    }
}

/// Draws ticks with slanted names.
fn askew(svg: &mut Svg, plot: &Plot, ticks: &[(f64, String)]) {
    for (at, name) in ticks {
        plot.tick(svg, *at, "");
        let (x, y) = (plot.x(*at) + 4.0, plot.bottom + 16.0);
        svg.askew((x, y), 12.0, SOFT, name);
    }
}

/// Powers of ten in a range of logarithms, and 2 and 5 times those if there are few.
fn decades(range: &Range) -> Vec<(f64, String)> {
    let factors: &[f64] = if range.high - range.low > 3.0 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let powers = range.low.floor() as i32..=range.high.ceil() as i32;
    let ticks = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)));
    ticks
        .filter(|tick| (range.low..=range.high).contains(&tick.log10()))
        .map(|tick| (tick.log10(), in_figure(tick, Digits::Three)))
        .collect()
}

/// Draws the interquartile range as a box with its median, and lines to minimum and maximum.
fn quartile_box(svg: &mut Svg, plot: &Plot, colour: &str, (left, right): (f64, f64), quartiles: [f64; 5]) {
    let [least, lower, median, upper, greatest] = quartiles.map(|value| plot.y(value));
    let stroke = format!("stroke=\"{colour}\" stroke-width=\"1.3\"");
    let x = f64::midpoint(left, right);
    svg.line((x, least), (x, lower), &stroke);
    svg.line((x, upper), (x, greatest), &stroke);
    let style = format!("fill=\"{colour}\" fill-opacity=\"0.16\" {stroke}");
    svg.rectangle((left, upper), (right - left, lower - upper), &style);
    svg.line(
        (left, median),
        (right, median),
        &format!("stroke=\"{colour}\" stroke-width=\"2.4\""),
    );
}

/// Draws runs as points. Those of one level lie side by side so that equal ones are visible; the order is always the
/// same.
fn points(svg: &mut Svg, plot: &Plot, scale: Scale, column: &Column<'_>, half: f64) {
    /// The fractional parts of its multiples fill the width evenly from the first point on.
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let style = format!("fill=\"{}\" fill-opacity=\"0.42\"", column.colour);
    for (i, &(x, y)) in (1_u32..).zip(&column.points) {
        let aside = if column.to > column.from {
            0.0
        } else {
            1.6 * half * ((f64::from(i) * GOLDEN).fract() - 0.5)
        };
        svg.circle((plot.x(place(scale, x)) + aside, plot.y(y)), 2.7, &style, "");
    }
}

/// Draws the mean as a diamond, with its interval.
fn mean(svg: &mut Svg, plot: &Plot, column: &Column<'_>, (left, right): (f64, f64)) {
    const SIZE: f64 = 5.5;
    let Spread { low, mean, high } = column.mean;
    if !mean.is_finite() {
        return;
    }
    let (x, y) = (f64::midpoint(left, right), plot.y(mean));
    if column.to > column.from {
        let style = format!("stroke=\"{}\" stroke-width=\"2.2\"", column.colour);
        svg.line((left, y), (right, y), &style);
    }
    if high > low {
        // Separates it from the points behind.
        let halo = "stroke=\"#ffffff\" stroke-width=\"4.5\" stroke-opacity=\"0.8\"";
        svg.line((x, plot.y(low)), (x, plot.y(high)), halo);
        let style = format!("stroke=\"{INK}\" stroke-width=\"1.6\"");
        svg.line((x, plot.y(low)), (x, plot.y(high)), &style);
        for end in [low, high] {
            svg.line((x - SIZE, plot.y(end)), (x + SIZE, plot.y(end)), &style);
        }
    }
    let corners = [(x, y - SIZE), (x + SIZE, y), (x, y + SIZE), (x - SIZE, y)];
    svg.polygon(
        corners,
        &format!("fill=\"{INK}\" stroke=\"#ffffff\" stroke-width=\"1\""),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(label: &str, from: f64, to: f64, points: Vec<(f64, f64)>) -> Column<'_> {
        Column {
            label,
            colour: "#123456",
            from,
            to,
            mean: Spread {
                low: 1.0,
                mean: 2.0,
                high: 3.0,
            },
            quartiles: None,
            points,
        }
    }

    fn drawn(scale: Scale, columns: &[Column<'_>]) -> String {
        let outcomes = Outcomes {
            title: "after < all",
            across: "x",
            up: "y",
            scale,
            columns,
        };
        let curves = Panel {
            title: "t",
            across: "generation",
            up: "fitness",
            ..Panel::default()
        };
        factor("t", std::slice::from_ref(&curves), &outcomes)
    }

    #[test]
    fn each_run_is_a_point_and_each_level_has_its_mean() {
        let text = drawn(
            Scale::Names,
            &[
                column("a", 0.0, 0.0, vec![(0.0, 1.0), (0.0, 1.0)]),
                column("b", 1.0, 1.0, vec![(1.0, 3.0)]),
            ],
        );
        assert_eq!(
            (text.matches("<circle").count(), text.matches("<polygon").count()),
            (3, 2)
        );
        let mut places: Vec<&str> = text.lines().filter(|line| line.starts_with("<circle")).collect();
        places.dedup();
        assert_eq!(places.len(), 3, "equal runs are seen");
        assert!(text.contains(">a<") && text.contains(">b<") && text.contains("after &lt; all"));
    }

    #[test]
    fn boxes_reach_from_quartile_to_quartile() {
        let mut one = column("a", 0.0, 0.0, vec![]);
        one.quartiles = Some([0.0, 1.0, 2.0, 3.0, 4.0]);
        let text = drawn(Scale::Names, &[one]);
        let shape = text
            .lines()
            .find(|line| line.contains("fill-opacity=\"0.16\""))
            .expect("a box");
        // The axis goes from 0 at 322 to 4 at 52.
        assert!(
            shape.contains("y=\"119.5\"") && shape.contains("height=\"135\""),
            "{shape}"
        );
    }

    #[test]
    fn names_without_room_are_slanted() {
        let long = [
            "arenas/first.toml",
            "arenas/second.toml",
            "arenas/third.toml",
            "arenas/fourth.toml",
        ];
        let columns: Vec<Column<'_>> = (0_u8..)
            .zip(long)
            .map(|(i, name)| column(name, i.into(), i.into(), vec![]))
            .collect();
        assert!(drawn(Scale::Names, &columns).contains("rotate(-35"));
        assert!(!drawn(Scale::Names, &columns[..1]).contains("rotate(-35"));
    }

    #[test]
    fn ranges_of_levels_stand_on_an_axis_of_numbers() {
        let text = drawn(
            Scale::Linear,
            &[
                column("0 to 1", 0.0, 1.0, vec![(0.5, 1.0)]),
                column("1.1 to 2", 1.1, 2.0, vec![(1.5, 3.0)]),
            ],
        );
        assert!(!text.contains(">0 to 1<") && text.contains(">0.5<"));
        let text = drawn(
            Scale::Logarithmic,
            &[column("a", 0.001, 0.01, vec![]), column("b", 0.02, 10.0, vec![])],
        );
        for power in ["0.001", "0.01", "0.1", "1", "10"] {
            assert!(text.contains(&format!(">{power}<")), "{power}");
        }
    }

    #[test]
    fn nothing_finite_is_no_data() {
        let mut one = column("a", 0.0, 0.0, vec![]);
        one.mean = Spread {
            low: f64::NAN,
            mean: f64::NAN,
            high: f64::NAN,
        };
        let text = drawn(Scale::Names, &[one]);
        assert!(!text.contains("NaN") && text.matches(">no data<").count() == 2);
    }

    #[test]
    fn ordered_levels_go_from_one_colour_to_another() {
        let styles = level_styles(3, true);
        assert_eq!((styles[0].0.as_str(), styles[2].0.as_str()), ("#a06500", "#1f2d7a"));
        assert_ne!(styles[0].1, styles[1].1);
        assert_eq!(level_styles(1, true)[0].0, UNORDERED[0]);
        assert_eq!(level_styles(9, false).len(), 9);
    }
}
