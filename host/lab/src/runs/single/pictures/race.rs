//! Candidates of a race by the episodes that all have spent.

use oneiro_evolve::settings::Kind;
use oneiro_report::figures::plot::{EPISODES, Plot, Range};
use oneiro_report::figures::svg::{Anchor, BOLD, Svg};

use super::Picture;

pub(super) const PICTURE: Picture = Picture {
    name: "race.svg",
    about: "a picture of the remaining candidates, by episodes spent",
    caption: "Candidates in each generation by episodes spent: at each rise, a race begins with the survivors of the last and new ones around them.",
    is_of_champion: false,
    is_drawn: |single| single.experiment.settings().evolution.kind == Kind::Race,
    draw: |run| {
        if run.rounds.is_empty() {
            return None;
        }
        let title = format!("{}, seed {}: candidates of the race", run.experiment.name(), run.seed);
        let counts: Vec<u32> = run.rounds.iter().map(|round| round.candidates).collect();
        Some(drawn(&title, &counts, run.spent))
    },
};

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 56.0;
const RIGHT: f64 = 26.0;
const COLOUR: &str = "#2b3a8f";

/// Draws the number of each generation's candidates over its episodes.
fn drawn(title: &str, candidates: &[u32], spent: &[u64]) -> String {
    let up = "candidates";
    let plot = Plot {
        left: LEFT,
        right: WIDTH - RIGHT,
        top: TOP,
        bottom: HEIGHT - BOTTOM,
        across: Range::between(0.0, spent.last().map_or(0.0, |end| *end as f64), 8),
        up: Range::holding(candidates.iter().map(|count| f64::from(*count)), 5),
    };
    let begins = std::iter::once(&0).chain(spent);
    let steps = begins.zip(spent).zip(candidates);
    let steps = steps.flat_map(|((from, to), count)| [from, to].map(|at| (*at as f64, f64::from(*count))));
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.words((LEFT, 28.0), 16.0, Anchor::Start, BOLD, title);
    plot.begin(&mut svg, EPISODES, up);
    plot.axes(&mut svg, EPISODES, up);
    plot.line(&mut svg, &steps.collect::<Vec<_>>(), COLOUR, "stroke-width=\"2\"", up);
    svg.raw("</g>");
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generation_is_as_wide_as_its_episodes() {
        let svg = drawn("t", &[10, 5], &[20, 30]);
        let line = svg.lines().find(|line| line.starts_with("<polyline")).unwrap();
        let points: Vec<f64> = line
            .split('"')
            .nth(1)
            .unwrap()
            .split([' ', ','])
            .map(|x| x.parse().unwrap())
            .collect();
        let [x0, y0, x1, y1, x2, y2, x3, y3] = points[..] else {
            panic!("{line}");
        };
        assert_eq!((x0, x1, x3), (LEFT, x2, WIDTH - RIGHT));
        assert!((x1 - x0 - 2.0 * (x3 - x2)).abs() < 0.1 && y0 == y1 && y2 == y3 && y0 < y2);
    }
}
