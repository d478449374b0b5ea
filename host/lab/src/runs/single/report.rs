//! The page of a finished run: how the evolution went, the champion, what was set, and what to do next. It depends only on
//! the run's results, so that it is always the same.

use oneiro::automode::Form;
use oneiro::parameter::Choice;
use oneiro_base::console::counted;
use oneiro_evolve::Champion;
use oneiro_evolve::appraisal::Appraisal;
use oneiro_evolve::race::Round;
use oneiro_evolve::settings::Kind;
use oneiro_report::figures::escaped;
use oneiro_report::numbers::{Digits, count, shown};
use oneiro_report::page::{Cell, Head, Row, Section, document, facts, figure, paragraph, table};

use super::pictures::{Drawn, Picture};
use super::trace::trace_every;
use super::{CHAMPION_GENES, REPLAY};
use crate::lives::measures::{self, Frames, Meter};
use crate::runs::report::{commands, settings};

/// Significant digits of scores.
const DIGITS: Digits = Digits::Four;
/// The page, with the run's pictures.
pub(super) fn html(run: &Drawn<'_>, pictures: &[(&Picture, String)]) -> String {
    let mut number = 0;
    let mut figures = |is_of_champion: bool| -> String {
        let own = pictures.iter().filter(|(own, _)| own.is_of_champion == is_of_champion);
        own.map(|(own, svg)| {
            number += 1;
            let words = format!("{} The file {} is this figure.", own.caption, own.name);
            figure(&format!("Figure {number}"), &words, svg)
        })
        .collect()
    };
    let [path, evolution] = [true, false].map(&mut figures);
    let sections = [
        Section::new("champion", "Champion", champion(run) + &path + &measured(run)),
        Section::new("evolution", "Evolution", evolution + &races(run) + &finalists(run)),
        Section::new("settings", "Settings", settings(&run.experiment.changed())),
        Section::new("next", "What to do next", next(run)),
        Section::new("genes", "Genes", genes(run)),
    ];
    let title = format!("{}, seed {}", run.experiment.name(), run.seed);
    document(&title, &lead(run), &sections)
}

fn lead(run: &Drawn<'_>) -> String {
    let evolution = &run.experiment.settings().evolution;
    let generations = counted(run.rows.len(), "generation", "generations");
    let what = match evolution.kind {
        Kind::Race => format!("An iterated race of {generations}"),
        kind => format!("An evolution ({}) of {generations}", kind.word()),
    };
    format!("<p class=\"lead\">{}.</p>\n", escaped(&what))
}

/// A mean with its interval.
fn mean(own: &Appraisal) -> String {
    let [low, high] = own.interval();
    let [mean, low, high] = [own.mean, low, high].map(|x| shown(x, DIGITS));
    format!("{mean} (95 %: {low} to {high})")
}

fn who(own: &Champion) -> String {
    format!("individual {} of generation {}", own.individual, own.generation)
}

fn champion(run: &Drawn<'_>) -> String {
    let experiment = run.experiment;
    let score = |own: &Champion| shown(own.fitness.into(), DIGITS);
    let mut all = vec![
        ("champion", who(run.champion)),
        ("score", format!("{} in its generation", score(run.champion))),
    ];
    if let Some(own) = run.appraisal {
        let episodes = counted(own.lives, "new episode", "new episodes");
        all.push(("mean", format!("{} in {episodes}", mean(&own))));
    }
    // The first finalist is the luckiest.
    if let Some(luckiest) = run.finalists.first().filter(|own| *own != run.champion) {
        let words = format!("{}, score {}, by luck", who(luckiest), score(luckiest));
        all.push(("luckiest", words));
    }
    let spent = experiment.budget().unwrap_or_else(|| {
        let episodes = experiment.episodes().total();
        format!("{} episodes", count(episodes))
    });
    all.extend([
        ("budget", spent),
        (
            "episode",
            counted(experiment.world().cycles(), "control cycle", "control cycles"),
        ),
        (
            "trials",
            counted(
                experiment.settings().trials,
                "episode an individual",
                "episodes an individual",
            ),
        ),
    ]);
    facts(&all)
}

/// Measures of the champion's episode, if every cycle was recorded.
fn measured(run: &Drawn<'_>) -> String {
    let world = run.experiment.world();
    let trace = run
        .trace
        .filter(|trace| !trace.is_empty() && trace_every(run.experiment) == 1);
    let Some(trace) = trace.filter(|_| world.robots() == 1) else {
        return String::new();
    };
    let all = measures::descriptors(world);
    let mut meter = Meter::new(Frames::new(world, world.cycles(), &all).of(run.first_key()));
    meter.add_all(trace);
    let measured = meter.finish();
    let row = |own: &measures::Descriptor| -> Row {
        let column = &own.column;
        vec![
            Cell::code(&column.name),
            Cell::number(shown(own.value(&measured), DIGITS)),
            Cell::text(column.unit),
            Cell::text(&column.about),
        ]
        .into()
    };
    let rows: Vec<Row> = all.iter().map(row).collect();
    let head = [
        Head::Text("measure"),
        Head::Number("value"),
        Head::Text("unit"),
        Head::Text("meaning"),
    ];
    table("", "Measures of that episode.", &head, &rows)
}

/// What became of the candidates of each race.
fn races(run: &Drawn<'_>) -> String {
    let mut before = 0;
    let rounds: Vec<(&Round, u64)> = run.rounds.iter().zip(run.spent.iter().copied()).collect();
    let races = rounds.chunk_by(|(a, _), (b, _)| a.race == b.race);
    let rows: Vec<Row> = races
        .filter_map(|own| {
            let ((first, _), (last, spent)) = (own.first()?, own.last()?);
            let episodes = spent - std::mem::replace(&mut before, *spent);
            let numbers = [first.race.into(), first.candidates.into(), last.survivors.into()];
            let numbers = numbers.into_iter().chain([own.len() as u64, episodes]);
            Some(
                numbers
                    .map(|number| Cell::number(count(number)))
                    .collect::<Vec<_>>()
                    .into(),
            )
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = ["race", "candidates", "survivors", "generations", "episodes"].map(Head::Number);
    table(
        "Races",
        "The next race samples new candidates around the survivors.",
        &head,
        &rows,
    )
}

/// Those that were re-evaluated after the last generation.
fn finalists(run: &Drawn<'_>) -> String {
    if run.appraised().next().is_none() {
        return String::new();
    }
    let words = match run.experiment.settings().evolution.kind {
        Kind::Race => "The run\u{2019}s luckiest, and the survivors of its last race, in common new episodes.",
        _ => "Finalists: the run\u{2019}s luckiest and the optimiser\u{2019}s best others, in common new episodes.",
    };
    let mut all: Vec<_> = run.appraised().collect();
    all.sort_by(|(_, a), (_, b)| b.mean.total_cmp(&a.mean));
    let row = |&(own, appraisal): &(&Champion, Appraisal)| Row {
        cells: vec![
            Cell::number(count(own.generation.into())),
            Cell::number(count(own.individual.into())),
            Cell::number(shown(own.fitness.into(), DIGITS)),
            Cell::number(mean(&appraisal)),
        ],
        sum: own == run.champion,
    };
    let rows: Vec<Row> = all.iter().map(row).collect();
    let head = ["generation", "individual", "score then", "mean of new episodes"].map(Head::Number);
    table("", words, &head, &rows)
}

fn next(run: &Drawn<'_>) -> String {
    let experiment = run.experiment;
    let settings = experiment.settings();
    let evolution = &settings.evolution;
    let is_outside = run.trace.is_none();
    let all = [
        (
            !is_outside,
            "replay RUN",
            format!("play the champion\u{2019}s episode: {REPLAY}.html"),
        ),
        (
            evolution.has_archive() && !is_outside,
            "replay RUN --elites",
            "play the elites: archive.html".to_owned(),
        ),
        (
            evolution.is_coevolution(),
            "evaluate --tournament --genomes RUN",
            "let all generations of both populations compete".to_owned(),
        ),
        (
            true,
            "evaluate --genomes RUN --trials 100 --seed 2 --summary",
            "score the champion in 100 new episodes".to_owned(),
        ),
        (
            !is_outside,
            "verify --recompute RUN",
            "compute the run again and compare".to_owned(),
        ),
        (
            !evolution.is_coevolution(),
            "compare RUN OTHER_RUNS",
            "compare this experiment with others".to_owned(),
        ),
    ];
    let all: Vec<(&str, String)> = all
        .into_iter()
        .filter_map(|(is_there, command, about)| is_there.then_some((command, about)))
        .collect();
    commands(&all)
}

/// The champion as text, or its genes.
fn genes(run: &Drawn<'_>) -> String {
    let layout = run.experiment.world().gene_layout();
    let genome = &run.champion.genome;
    if let Some(form) = Form::of(layout) {
        let text = form.text(genome);
        return format!("<pre>{}</pre>\n", escaped(&text).replace(" --s", "\n--s"));
    }
    let genes = || layout.all().iter().zip(genome);
    let at_end = genes()
        .filter(|(gene, value)| gene.range.is_some_and(|range| range.contains(*value)))
        .count();
    let words = format!(
        "{} in {CHAMPION_GENES}; {at_end} at an end of its range.",
        counted(genome.len(), "gene", "genes")
    );
    let row = |(gene, value): (&oneiro::world::Gene, &f32)| -> Row {
        vec![Cell::code(&gene.name), Cell::number(shown((*value).into(), DIGITS))].into()
    };
    let rows: Vec<Row> = genes().map(row).collect();
    let all = table("", "", &[Head::Text("gene"), Head::Number("value")], &rows);
    format!(
        "{}<details>\n<summary>All genes</summary>\n{all}</details>\n",
        paragraph(&words)
    )
}
