//! Pairs of factors: the mean outcome for each pair of their levels.

use oneiro_report::figures::{HeatMap, Side, Square, escaped, heat_map};
use oneiro_report::page::{Section, figure, id, joined, paragraph};

use super::Tables;
use super::effects::{Effects, FactorEffect};
use super::pictures::MOST_COLUMNS;
use super::runs::Runs;
use super::sample::Moments;

/// Maximum number of factors whose pairs are all shown; if there are more, those that explain the most.
const FACTORS: usize = 4;
/// Shows one picture at a time; on paper, and without scripts, all are visible.
const SCRIPT: &str = "<script>
{
  const choice = document.getElementById('pair-choice');
  const show = () => document.querySelectorAll('#pairs figure').forEach(figure => {
    figure.hidden = figure.id !== choice.value;
  });
  choice.parentElement.hidden = false;
  choice.addEventListener('change', show);
  show();
}
</script>
";

/// Two factors, and the outcome for each pair of their groups.
struct Pair {
    factors: [usize; 2],
    squares: Vec<Option<Square>>,
}

/// The section, if there are two factors with several levels.
pub(super) fn section(tables: &Tables<'_>, runs: &Runs, effects: &Effects) -> Option<Section> {
    let factors = shown(runs, effects);
    let pairs: Vec<Pair> = factors
        .iter()
        .enumerate()
        .flat_map(|(place, &first)| factors[place + 1..].iter().map(move |&second| [first, second]))
        .map(|factors| pair(runs, factors))
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let means = || {
        pairs
            .iter()
            .flat_map(|pair| &pair.squares)
            .flatten()
            .map(|square| square.mean)
    };
    let finite = || means().filter(|mean| mean.is_finite());
    let ends = (
        finite().fold(f64::INFINITY, f64::min),
        finite().fold(f64::NEG_INFINITY, f64::max),
    );
    let of_all = if factors.len() < effects.factors.len() {
        format!(
            " Of {} factors, the {} that explain the most, of those with no more than {MOST_COLUMNS} levels.",
            effects.factors.len(),
            factors.len()
        )
    } else {
        String::new()
    };
    let words = format!(
        "Mean of {} over all levels of the other factors, and the number of runs. Darker is higher, on one scale in all pictures; the \
         {} of each picture has a frame.{of_all}",
        tables.outcome.1,
        if tables.is_less_better { "lowest" } else { "highest" }
    );
    let figures = pairs
        .iter()
        .zip(1..)
        .map(|(pair, number)| picture(tables, runs, pair, number, ends));
    let figures: Vec<String> = figures.collect();
    let choice = if pairs.len() > 1 {
        choice(runs, &pairs)
    } else {
        String::new()
    };
    let script = if pairs.len() > 1 { SCRIPT } else { "" };
    Some(Section::new(
        "pairs",
        "Pairs of factors",
        format!("{}{choice}{}{script}", paragraph(&words), figures.concat()),
    ))
}

/// Factors to show, in order.
fn shown(runs: &Runs, effects: &Effects) -> Vec<usize> {
    let fits = |effect: &&FactorEffect| runs.factors[effect.factor].groups.len() <= MOST_COLUMNS;
    let mut factors: Vec<_> = effects.factors.iter().filter(fits).collect();
    let key = |explained: f64| if explained.is_nan() { -1.0 } else { explained };
    factors.sort_by(|a, b| key(b.explained).total_cmp(&key(a.explained)));
    factors.truncate(FACTORS);
    let mut shown: Vec<usize> = factors.into_iter().map(|effect| effect.factor).collect();
    shown.sort_unstable();
    shown
}

fn pair(runs: &Runs, factors: [usize; 2]) -> Pair {
    let [columns, rows] = factors.map(|factor| runs.factors[factor].groups.len());
    let mut sums = vec![(Moments::default(), 0); columns * rows];
    for run in &runs.all {
        let [column, row] = factors.map(|factor| runs.group(run, factor));
        let (moments, count) = &mut sums[row * columns + column];
        *count += 1;
        if run.outcome.is_finite() {
            moments.add(run.outcome);
        }
    }
    let square = |(moments, runs): (Moments, usize)| {
        (runs > 0).then(|| Square {
            mean: moments.mean(),
            runs: if moments.count > 0 {
                moments.count as usize
            } else {
                runs
            },
        })
    };
    Pair {
        factors,
        squares: sums.into_iter().map(square).collect(),
    }
}

fn name(number: u32) -> String {
    format!("Pair {number}")
}

fn picture(tables: &Tables<'_>, runs: &Runs, pair: &Pair, number: u32, (low, high): (f64, f64)) -> String {
    let [across, up] = pair.factors.map(|factor| &runs.factors[factor]);
    let labels = |factor: usize| -> Vec<&str> {
        let groups = runs.factors[factor].groups.iter();
        groups.map(|group| group.label.as_str()).collect()
    };
    let [of_across, of_up] = pair.factors.map(labels);
    let svg = heat_map(&HeatMap {
        is_less_better: tables.is_less_better,
        across: Side {
            name: &across.name,
            levels: &of_across,
        },
        up: Side {
            name: &up.name,
            levels: &of_up,
        },
        value: &format!("mean of {}", tables.outcome.1),
        low,
        high,
        squares: &pair.squares,
    });
    figure(&name(number), &format!("{} and {}.", across.name, up.name), &svg)
}

/// The list to choose a picture from, hidden unless a script runs.
fn choice(runs: &Runs, pairs: &[Pair]) -> String {
    let pairs: Vec<(u32, &Pair)> = (1..).zip(pairs).collect();
    let options = joined(&pairs, |(number, pair)| {
        let [across, up] = pair.factors.map(|factor| escaped(&runs.factors[factor].name));
        format!("<option value=\"{}\">{across} and {up}</option>\n", id(&name(*number)))
    });
    format!("<label class=\"choice\" hidden=\"\">Show <select id=\"pair-choice\">\n{options}</select></label>\n")
}
