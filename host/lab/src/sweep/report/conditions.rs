//! Report of several conditions, such as runs of different experiments, that have one score.

use std::collections::BTreeMap;

use oneiro_base::contents::Column;
use oneiro_base::exit::Result;
use oneiro_report::csv::{Csv, known};
use oneiro_report::numbers::{NONE, count, shown, significant};
use oneiro_report::page::{self, Cell, Head, Row, Section, list, paragraph, table};
use serde_json::{Value, json};

use super::cells::{Cells, LISTED, counted};
use super::champions::target;
use super::curves::Curves;
use super::effects::{Comparison, Effects, LEAST};
use super::runs::{Run, Runs};
use super::sample::Sample;
use super::{Compared, DIGITS, Tables, comparisons, factors, json as figures, pictures};

/// The column of the table of runs that names each run's condition.
pub(crate) const CONDITION: &str = "condition";

/// What conditions are compared by, and what readers should know.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    /// The table of runs has `run`, `id`, [`CONDITION`], `seed`, the outcome and `result`; that of generations `run`, the time and the
    /// value.
    pub tables: Tables<'a>,
    /// Episodes of one run of each condition.
    pub episodes: BTreeMap<String, u64>,
    /// How the outcome came about.
    pub about: String,
    /// What makes the comparison doubtful.
    pub warnings: &'a [String],
    /// Keys in which the experiments differ.
    pub differences: &'a [String],
    /// Words below the figure.
    pub caption: String,
    /// Where each run is, as HTML, by its number.
    pub sources: Vec<String>,
}

/// A report of conditions.
#[derive(Debug)]
pub(crate) struct Report {
    /// The page, self-contained.
    pub html: String,
    /// All conditions, in their order, as CSV.
    pub conditions_csv: String,
    /// All comparisons of two conditions, as CSV.
    pub effects_csv: String,
    pub json: Value,
    /// A row of text for each condition: its name, runs, episodes, median with its interval, and mean.
    pub rows: Vec<Vec<String>>,
    /// A row of text for each pair that is tested: its names, the difference of the means, effect size and p.
    pub pairs: Vec<Vec<String>>,
}

/// The heads of [`Report::rows`].
pub(crate) const HEADS: [&str; 7] = ["condition", "runs", "NaN", "episodes a run", "median", "95 %", "mean"];

/// The heads of [`Report::pairs`]. A is the chance that a run of the first scores more than one of the second.
pub(crate) const HEADS_OF_PAIRS: [&str; 6] = ["first", "second", "difference of means", "A", "p", "p (Holm)"];

/// The columns of the table of conditions.
pub(crate) static COLUMNS: [Column; 13] = [
    Column::text(
        CONDITION,
        "its name: the experiment's, or a sweep's with the values of a cell",
    ),
    Column::whole("runs", "", "the number of its finished runs"),
    Column::whole(
        "nan",
        "",
        "the number of runs whose score is not a number; the columns below are without them",
    ),
    Column::whole(
        "episodes",
        "",
        "episodes that a run's evolution may spend, without those of finalists",
    ),
    Column::number("median", "", "the median of the runs' scores"),
    Column::number(
        "median_low",
        "",
        "the lower bound of the median's 95 % confidence interval by order statistics; empty for fewer than six runs",
    ),
    Column::number("median_high", "", "its upper bound"),
    Column::number("mean", "", "the mean of the runs' scores"),
    Column::number(
        "mean_low",
        "",
        "the lower bound of the mean's 95 % confidence interval, by Student's t",
    ),
    Column::number("mean_high", "", "its upper bound"),
    Column::number("sd", "", "the standard deviation of the runs' scores"),
    Column::number("min", "", "the lowest score"),
    Column::number("max", "", "the highest score"),
];

/// The columns of the table of comparisons, as in a sweep's report.
pub(crate) fn effects_columns() -> &'static [Column] {
    &comparisons::COLUMNS
}

/// Compares the conditions of two tables.
///
/// # Errors
/// As [`super::report`].
pub(crate) fn report(request: &Request<'_>) -> Result<Report> {
    let tables = &request.tables;
    debug_assert_eq!(tables.compared, Compared::Conditions);
    let runs = Runs::read(tables)?;
    let curves = Curves::read(tables, &runs)?;
    let samples = runs.samples(0);
    // Conditions are the levels of the only factor, and not cells besides.
    let effects = Effects::of(&runs, std::slice::from_ref(&samples), &Cells { ranked: Vec::new() });
    let names: Vec<&str> = runs.factors[0]
        .groups
        .iter()
        .map(|group| group.label.as_str())
        .collect();
    let conditions: Vec<Condition<'_>> = names
        .iter()
        .zip(&samples)
        .map(|(name, sample)| Condition {
            name,
            sample,
            episodes: request.episodes.get(*name).copied().unwrap_or_default(),
        })
        .collect();
    let sections = [
        summary(tables, &runs, &conditions),
        Section::new(
            "curves",
            "How runs went, and what came out",
            factors::verdict(&runs.factors[0], &samples, 0, &effects)
                + &pictures::picture(tables, &runs, &curves, &samples, 0)
                + &paragraph(&request.caption),
        ),
        tests(tables, &names, &effects),
        listed(request, &runs),
    ];
    Ok(Report {
        html: page::document(tables.title, &lead(request, &runs, &conditions), &sections),
        conditions_csv: csv(&conditions),
        effects_csv: comparisons::csv(&runs, &effects),
        json: json!({
            "title": tables.title,
            "score": request.about,
            "runs": runs.all.len(),
            "not_numbers": runs.outcomes().not_numbers,
            "conditions": conditions.iter().map(Condition::json).collect::<Vec<_>>(),
            "tests": effects.levels.comparisons.iter().map(|one| test(&names, one)).collect::<Vec<_>>(),
            "differences": request.differences,
            "warnings": request.warnings,
        }),
        rows: conditions.iter().map(Condition::texts).collect(),
        pairs: effects
            .levels
            .comparisons
            .iter()
            .map(|one| texts(&names, one))
            .collect(),
    })
}

/// One condition.
struct Condition<'a> {
    name: &'a str,
    sample: &'a Sample,
    episodes: u64,
}

impl Condition<'_> {
    fn runs(&self) -> usize {
        self.sample.values.len() + self.sample.not_numbers
    }

    fn json(&self) -> Value {
        let mut own = figures::figures(self.sample);
        let spread = self.sample.spread();
        let interval = self.sample.median_interval();
        own["name"] = self.name.into();
        own["runs"] = self.runs().into();
        own["episodes"] = self.episodes.into();
        own["median"] = json!(self.sample.quartiles()[2]);
        own["median_interval"] = json!(interval.map(|interval| [interval.low, interval.high]));
        own["mean_interval"] = json!([spread.low, spread.high]);
        own
    }

    fn texts(&self) -> Vec<String> {
        let plain = |x: f64| significant(x, DIGITS as usize);
        let interval = self.sample.median_interval();
        vec![
            self.name.to_owned(),
            self.runs().to_string(),
            self.sample.not_numbers.to_string(),
            self.episodes.to_string(),
            plain(self.sample.quartiles()[2]),
            interval.map_or_else(
                || "-".to_owned(),
                |interval| format!("{} to {}", plain(interval.low), plain(interval.high)),
            ),
            plain(self.sample.mean()),
        ]
    }
}

/// What is below the title.
fn lead(request: &Request<'_>, runs: &Runs, conditions: &[Condition<'_>]) -> String {
    let mut facts = vec![
        ("conditions", count(conditions.len() as u64)),
        ("runs", count(runs.all.len() as u64)),
        ("score", request.about.clone()),
    ];
    let not_numbers = runs.outcomes().not_numbers;
    if not_numbers > 0 {
        let words = format!(
            "{} of the runs have a score that is no number; they are left out of all else",
            count(not_numbers as u64)
        );
        facts.push(("NaN", words));
    }
    if !request.differences.is_empty() {
        facts.push(("differences", request.differences.join("; ")));
    }
    let warnings: Vec<&str> = request.warnings.iter().map(String::as_str).collect();
    let warnings = if warnings.is_empty() {
        String::new()
    } else {
        format!("<p><b>Read the comparison with care:</b></p>\n{}", list(&warnings))
    };
    format!(
        "<p class=\"lead\">Experiments side by side: what came out of each, and how sure the differences are.</p>\n{warnings}{}",
        page::facts(&facts)
    )
}

/// Table of the conditions.
fn summary(tables: &Tables<'_>, runs: &Runs, conditions: &[Condition<'_>]) -> Section {
    let words = format!(
        "One row per condition: {}. The interval of the median is that of 95 % confidence by order statistics, which needs six runs; that \
         of the mean is by Student\u{2019}s t. Episodes are those that the evolution of one run may spend, without those of finalists.",
        tables.outcome.1
    );
    let head = [
        Head::Text("Condition"),
        Head::Number("runs"),
        Head::Number("episodes a run"),
        Head::Number("median"),
        Head::Number("95 % of the median"),
        Head::Number("mean"),
        Head::Number("95 % of the mean"),
        Head::Number("s.d."),
        Head::Number("minimum"),
        Head::Number("maximum"),
    ];
    let range = |ends: Option<[f64; 2]>| {
        let words = |[low, high]: [f64; 2]| format!("{} to {}", shown(low, DIGITS), shown(high, DIGITS));
        Cell::number(ends.map_or_else(|| NONE.to_owned(), words))
    };
    let row = |own: &Condition<'_>| -> Row {
        let sample = own.sample;
        let [least, _, median, _, greatest] = sample.quartiles();
        let spread = sample.spread();
        let few = if sample.values.len() < LEAST {
            " <span class=\"small\">too few to test</span>"
        } else {
            ""
        };
        let number = |x| Cell::number(shown(x, DIGITS));
        let run = runs.all.iter().find(|run| runs.texts(&run.levels).eq([own.name]));
        let run = run.filter(|run| run.number < LISTED as u64).map(target);
        vec![
            run.map_or_else(
                || Cell::name(own.name),
                |run| Cell::html(format!("<a href=\"#{run}\">{}</a>", page::breakable(own.name))),
            ),
            Cell::number(counted(sample) + few),
            Cell::number(count(own.episodes)),
            number(median),
            range(sample.median_interval().map(|interval| [interval.low, interval.high])),
            number(spread.mean),
            range((sample.values.len() > 1).then_some([spread.low, spread.high])),
            number(sample.deviation()),
            number(least),
            number(greatest),
        ]
        .into()
    };
    let rows: Vec<Row> = conditions.iter().map(row).collect();
    let body = paragraph(&words) + &table("Table 1", "The conditions.", &head, &rows);
    Section::new("conditions", "Conditions", body)
}

/// Table of the runs, with links to their directories and pages.
fn listed(request: &Request<'_>, runs: &Runs) -> Section {
    let tables = &request.tables;
    let head = [
        Head::Number("Run"),
        Head::Text("condition"),
        Head::Number("seed"),
        Head::Number(tables.outcome.1),
        Head::Text("where it is"),
    ];
    let row = |run: &Run| -> Row {
        let source = request.sources.get(run.number as usize).cloned().unwrap_or_default();
        let mut cells = vec![Cell::number(format!(
            "<span id=\"{}\">{}</span>",
            target(run),
            run.number
        ))];
        cells.extend(runs.texts(&run.levels).map(Cell::name));
        cells.push(Cell::number(run.seed.to_string()));
        cells.push(Cell::number(shown(run.outcome, DIGITS)));
        cells.push(Cell::html(source));
        cells.into()
    };
    let rows: Vec<Row> = runs.all.iter().take(LISTED).map(row).collect();
    let words = if rows.len() < runs.all.len() {
        format!("The first {LISTED} runs; compare.csv has all.")
    } else {
        "All runs, condition by condition.".to_owned()
    };
    Section::new("runs", "Runs", paragraph(&words) + &table("", "", &head, &rows))
}

/// Tests of all pairs of conditions.
fn tests(tables: &Tables<'_>, names: &[&str], effects: &Effects) -> Section {
    let family = &effects.levels;
    let body = if family.comparisons.is_empty() {
        paragraph(&format!(
            "Fewer than two conditions have {LEAST} runs whose score is a number: none is tested."
        ))
    } else {
        let words = format!(
            "Pairs of conditions: all of them, or, of more than {}, each against the best. The family: {}.{}{}",
            super::effects::FEW,
            comparisons::size_of(family),
            comparisons::untested(family, "conditions"),
            comparisons::hopeless(family)
        );
        let pair = |one: &Comparison| one.pair.map(|place| Cell::name(names[place])).into();
        let head = [Head::Text("first"), Head::Text("second")];
        comparisons::tests(tables) + &paragraph(&words) + &comparisons::comparisons(family, &head, pair)
    };
    Section::new("effects", "Effect sizes and tests", body)
}

fn csv(conditions: &[Condition<'_>]) -> String {
    let mut table = Csv::new(&COLUMNS);
    for own in conditions {
        let sample = own.sample;
        let [least, _, median, _, greatest] = sample.quartiles();
        let interval = sample.median_interval();
        let spread = sample.spread();
        let [low, high] = interval.map_or([f64::NAN; 2], |interval| [interval.low, interval.high]);
        let is_spread = sample.values.len() > 1;
        let mean = [spread.low, spread.high].map(|end| if is_spread { end } else { f64::NAN });
        let figures = [
            median,
            low,
            high,
            spread.mean,
            mean[0],
            mean[1],
            sample.deviation(),
            least,
            greatest,
        ];
        let counts = [own.runs() as u64, sample.not_numbers as u64, own.episodes];
        let row = std::iter::once(own.name.to_owned())
            .chain(counts.map(|n| n.to_string()))
            .chain(figures.map(known));
        table.row(row);
    }
    table.text()
}

/// A comparison of two conditions as JSON.
fn test(names: &[&str], one: &Comparison) -> Value {
    json!({
        "first": names[one.pair[0]],
        "second": names[one.pair[1]],
        "n": one.runs,
        "difference": one.means[0] - one.means[1],
        "a": one.a,
        "delta": one.delta,
        "delta_interval": one.interval.map(|interval| [interval.low, interval.high]),
        "u": one.u,
        "p": one.p,
        "p_holm": one.p_holm,
    })
}

/// The same as text.
fn texts(names: &[&str], one: &Comparison) -> Vec<String> {
    let plain = |x: f64| significant(x, DIGITS as usize);
    let figures = [one.means[0] - one.means[1], one.a, one.p, one.p_holm];
    one.pair
        .map(|place| names[place].to_owned())
        .into_iter()
        .chain(figures.map(plain))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use oneiro_base::plain;

    use super::*;

    /// A score that is no number is counted, and left out of the rest. Conditions keep their order, even those named like numbers.
    #[test]
    fn scores_that_are_no_numbers_are_counted() {
        let folder = std::env::temp_dir().join(format!("oneiro-conditions-{}", std::process::id()));
        plain::make_directory(&folder).unwrap();
        let [runs, curves] = ["runs.csv", "curves.csv"].map(|name| folder.join(name));
        let (mut rows, mut steps) = (String::new(), String::new());
        for run in 0..14_u32 {
            let condition = if run < 7 { "20" } else { "10" };
            let score = if run == 3 {
                String::new()
            } else {
                format!("{}.0625", 100 * (run % 7) + run / 7)
            };
            let _ = writeln!(rows, "{run},id{run},{condition},{},{score},result{run}", run % 7);
            let _ = writeln!(steps, "{run},50,1\n{run},100,{run}");
        }
        let write = |path: &std::path::Path, text: String| oneiro_base::disk::write(path, text.as_bytes()).unwrap();
        write(&runs, format!("run,id,{CONDITION},seed,score,result\n{rows}"));
        write(&curves, format!("run,episodes,best\n{steps}"));
        let request = Request {
            tables: Tables {
                title: "t",
                results: &runs,
                generations: &curves,
                factors: &[CONDITION.to_owned()],
                compared: Compared::Conditions,
                outcome: ("score", "score"),
                is_less_better: false,
                others: &[],
                unfinished: None,
                time: ("episodes", "episodes spent"),
                value: ("best", "best score so far"),
                spent: None,
            },
            episodes: BTreeMap::from([("20".to_owned(), 100), ("10".to_owned(), 200)]),
            about: "a score".to_owned(),
            warnings: &["w < v".to_owned()],
            differences: &[],
            caption: String::new(),
            sources: Vec::new(),
        };
        let report = report(&request).unwrap();
        let _ = std::fs::remove_dir_all(&folder);
        assert_eq!(report.json["not_numbers"], 1);
        // Six numbers: the interval of the median is from the least to the greatest. Seven: the same.
        let lines: Vec<&str> = report.conditions_csv.lines().collect();
        assert!(
            lines[1].starts_with("20,7,1,100,300.062,0.0625,600.062,"),
            "{}",
            lines[1]
        );
        assert!(
            lines[2].starts_with("10,7,0,200,301.062,1.0625,601.062,301.062,"),
            "{}",
            lines[2]
        );
        assert_eq!(report.rows[0][..6], ["20", "7", "1", "100", "300.1", "0.0625 to 600.1"]);
        assert!(report.html.contains("(+1 NaN)") && report.html.contains("w &lt; v"));
        // One pair, the later condition first, as levels of a sweep's keys are.
        assert_eq!(report.json["tests"][0]["first"], "10");
        assert_eq!(report.json["tests"].as_array().unwrap().len(), 1);
        assert!(report.json["tests"][0]["p_holm"] == report.json["tests"][0]["p"]);
        let p = report.json["tests"][0]["p"].as_f64().unwrap();
        assert_eq!(report.pairs[0][..2], ["10", "20"]);
        assert!(
            (report.pairs[0][4].parse::<f64>().unwrap() - p).abs() < 1e-3 * p,
            "{:?} {p}",
            report.pairs
        );
    }
}
