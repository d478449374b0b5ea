//! A study's claims as its report has them: an abstract, a section for each question with the evidence for each verdict, the
//! verdicts under other assumptions, and a glossary.

use std::fmt::Write;

use crate::report::figures::escaped;
use crate::report::numbers::{NONE, probability, shown};
use crate::report::page::{Cell, Head, Row, Section, id, joined, paragraph, table};
use crate::studies::claims::{Claim, Effect, HOLDS_IN, RESAMPLES, Table, Test, Verdict};
use crate::studies::file::Arm;

/// Significant digits of effects and statistics.
const DIGITS: usize = 4;

/// The answer first: how many claims are reproduced, which ones by question, and a table of their main effects. `about` is a
/// paragraph on the study, as HTML.
pub(super) fn summary(table_of: &Table, claims: &[Claim], about: &str) -> Section {
    let count = |verdict| claims.iter().filter(|claim| claim.verdict == verdict).count();
    let mut verdicts = vec![Verdict::Reproduced, Verdict::NotReproduced, Verdict::Undecided];
    verdicts.extend(Some(Verdict::NotMeasured).filter(|&verdict| count(verdict) > 0));
    let tally = joined(&verdicts, |&verdict| {
        let (count, class, words) = (count(verdict), class(verdict), words(verdict));
        format!("<span class=\"{class}\"><b>{count}</b>{words}</span>\n")
    });
    let head = [
        Head::Text("Claim"),
        Head::Text("What the paper says"),
        Head::Text("Verdict"),
        Head::Text("Main effect"),
        Head::Number("here"),
        Head::Number("95 % interval"),
        Head::Number("paper"),
    ];
    let (mut answers, mut rows) = (String::new(), Vec::new());
    for (key, question) in table_of.questions() {
        let own: Vec<&Claim> = claims.iter().filter(|claim| claim.question == key).collect();
        let answer: Vec<String> = verdicts.iter().filter_map(|&verdict| answer(verdict, &own)).collect();
        let (words, answer) = (escaped(question), answer.join("; "));
        let _ = writeln!(answers, "<li><a href=\"#{key}\">{words}</a> {answer}.</li>");
        rows.push(Row {
            cells: vec![Cell::across(head.len(), question)],
            sum: true,
        });
        rows.extend(own.into_iter().map(|claim| Row::from(line(claim))));
    }
    let introduction = paragraph(&format!(
        "{} of the paper's {} claims are reproduced, each by a criterion that was fixed before anything was evolved. By \
         question:",
        count(Verdict::Reproduced),
        claims.len(),
    ));
    let caption = "All claims with their main effects, beside the paper's own figure where it prints one or one follows from \
                   what it prints. Intervals are over runs.";
    let answers = if claims.is_empty() {
        paragraph("Nothing has been judged.")
    } else {
        format!(
            "{introduction}<ul>\n{answers}</ul>\n<div class=\"tally\">\n{tally}</div>\n{}",
            table("", caption, &head, &rows)
        )
    };
    Section::new("abstract", "Abstract", format!("{about}{answers}"))
}

/// The claims among some that have a verdict, such as `reproduced: C1, C2`.
fn answer(verdict: Verdict, claims: &[&Claim]) -> Option<String> {
    let own = claims.iter().filter(|claim| claim.verdict == verdict);
    let links: Vec<String> = own.map(|claim| link(claim)).collect();
    (!links.is_empty()).then(|| format!("{}: {}", words(verdict), links.join(", ")))
}

fn link(claim: &Claim) -> String {
    format!("<a href=\"#{}\">{}</a>", id(&claim.id), escaped(&claim.id))
}

fn line(claim: &Claim) -> Vec<Cell> {
    // A claim judged in several combinations has no single combination as its main effect. Otherwise effects that can
    // be compared with the paper come first.
    let effects = &claim.effects;
    let scope = effects.first().filter(|effect| effect.name.starts_with(HOLDS_IN));
    let main = scope
        .or_else(|| effects.iter().find(|effect| effect.paper.is_some()))
        .or(effects.first());
    let mut cells = vec![
        Cell::html(link(claim)),
        Cell::text(&claim.statement),
        Cell::html(chip(claim.verdict, words(claim.verdict))),
    ];
    cells.extend(main.map_or_else(|| vec![Cell::across(4, NONE)], effect));
    cells
}

/// A section for each question: its claims in detail, and the figures and tables that `evidence` has for its key.
pub(super) fn by_question(table: &Table, claims: &[Claim], evidence: impl Fn(&str) -> String) -> Vec<Section> {
    let section = |(key, question): (&str, &str)| {
        let own: Vec<&Claim> = claims.iter().filter(|claim| claim.question == key).collect();
        Section::new(
            key.to_owned(),
            question.to_owned(),
            joined(&own, |claim| article(claim)) + &evidence(key),
        )
    };
    table.questions().into_iter().map(section).collect()
}

/// How claims were judged, for the methods of every study.
pub(super) fn judging() -> String {
    format!(
        "<h3>How claims were judged</h3>\n{}",
        paragraph(&format!(
            "The criterion of each claim was fixed, word for word, before anything was evolved. A run is the unit of analysis \
             wherever the paper's own test does not need another: individuals, robots and minutes of one run depend on each \
             other. The 95 % intervals of means are Student's over runs, those of ratios are by the delta method, and those of d \
             are percentiles of {RESAMPLES} bootstrap samples of runs. Holm's correction covers the tests that a claim or the \
             study names as one family."
        ))
    )
}

/// The meanings of all words that are particular to the study.
pub(super) fn glossary(table_of: &Table) -> Section {
    let mut words: Vec<(&String, &String)> = table_of.words.iter().collect();
    words.sort_by_key(|(word, _)| word.to_lowercase());
    let rows: Vec<Row> = words
        .into_iter()
        .map(|(word, meaning)| vec![Cell::text(word), Cell::text(meaning)].into())
        .collect();
    Section::new(
        "glossary",
        "Glossary",
        table("", "", &[Head::Text("Word"), Head::Text("Meaning")], &rows),
    )
}

fn article(claim: &Claim) -> String {
    let mut text = format!(
        "<article id=\"{}\" class=\"is-{}\">\n<h3>{} {}</h3>\n<blockquote>{}</blockquote>\n\
         <p><b>Preregistered.</b> {}</p>\n<p class=\"small\">The paper: {}. Unit of analysis: {}.</p>\n",
        id(&claim.id),
        class(claim.verdict),
        escaped(&claim.id),
        chip(claim.verdict, words(claim.verdict)),
        escaped(&claim.statement),
        escaped(&claim.criterion),
        escaped(&claim.source),
        escaped(&claim.unit),
    );
    if !claim.effects.is_empty() {
        let head = [
            Head::Text("Effect"),
            Head::Number("here"),
            Head::Number("95 % interval"),
            Head::Number("paper"),
        ];
        let rows: Vec<Row> = claim.effects.iter().map(|one| effect(one).into()).collect();
        text.push_str(&table("", "", &head, &rows));
    }
    if !claim.tests.is_empty() {
        let head = [
            Head::Text("Test"),
            Head::Text("Statistic"),
            Head::Number("value"),
            Head::Number("degrees of freedom"),
            Head::Number("p"),
            Head::Number("p, Holm"),
        ];
        let rows: Vec<Row> = claim.tests.iter().map(test).collect();
        text.push_str(&table("", "", &head, &rows));
    }
    if !claim.remark.is_empty() {
        text.push_str(&paragraph(&claim.remark));
    }
    text.push_str("</article>\n");
    text
}

fn effect(effect: &Effect) -> Vec<Cell> {
    let interval = effect.interval.map_or(NONE.to_owned(), |ends| {
        let [low, high] = ends.map(|end| shown(end, DIGITS));
        format!("{low} to {high}")
    });
    let paper = effect.paper.map_or(NONE.to_owned(), |value| shown(value, DIGITS));
    vec![
        Cell::text(&effect.name),
        Cell::number(shown(effect.value, DIGITS)),
        Cell::number(interval),
        Cell::number(format!("<span class=\"paper\">{paper}</span>")),
    ]
}

fn test(test: &Test) -> Row {
    vec![
        Cell::text(&test.name),
        Cell::html(format!("<i>{}</i>", escaped(&test.statistic))),
        Cell::number(shown(test.value, DIGITS)),
        Cell::number(degrees_of_freedom(test)),
        Cell::number(probability(test.p)),
        Cell::number(test.p_holm.map_or(NONE.to_owned(), probability)),
    ]
    .into()
}

/// Degrees of freedom, separated by commas.
pub(super) fn degrees_of_freedom(test: &Test) -> String {
    let degrees: Vec<String> = test.degrees_of_freedom.iter().map(|&df| shown(df, DIGITS)).collect();
    if degrees.is_empty() {
        NONE.to_owned()
    } else {
        degrees.join(", ")
    }
}

/// The claims under one assumption.
pub(crate) struct Assumed {
    pub(crate) arm: Arm,
    pub(crate) claims: Vec<Claim>,
}

/// The claims under every assumption.
pub(crate) struct Sensitivity {
    /// The study's own arm.
    pub(crate) main: Assumed,
    /// Other arms by subject.
    pub(crate) groups: Vec<(String, Vec<Assumed>)>,
}

impl Sensitivity {
    /// All arms, the study's own first.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Assumed> + Clone {
        std::iter::once(&self.main).chain(self.groups.iter().flat_map(|(_, group)| group))
    }
}

/// Table of verdicts by assumption.
pub(super) fn by_assumption(arms: &Sensitivity) -> String {
    let Sensitivity { main, groups } = arms;
    let mut head = vec![Head::Text("Assumption")];
    head.extend(main.claims.iter().map(|claim| Head::Text(&claim.id)));
    let mut rows = vec![assumed(main)];
    for (title, group) in groups.iter().filter(|(_, group)| !group.is_empty()) {
        rows.push(Row {
            cells: vec![Cell::across(head.len(), title)],
            sum: true,
        });
        rows.extend(group.iter().map(assumed));
    }
    let counts = (0..main.claims.len()).map(|column| {
        let asked = arms.all().filter_map(|one| one.claims.get(column));
        let asked = asked.filter(|claim| matches!(claim.verdict, Verdict::Reproduced | Verdict::NotReproduced));
        let reproduced = asked.clone().filter(|claim| claim.verdict == Verdict::Reproduced);
        Cell::text(&format!("{}/{}", reproduced.count(), asked.count()))
    });
    rows.push(Row {
        cells: std::iter::once(Cell::text("reproduced, of those decided"))
            .chain(counts)
            .collect(),
        sum: true,
    });
    let words = "Which claims hold under which assumption. Each row is the whole study again with one choice made \
                 otherwise; its own report lies in the directory arms. A verdict that changes from row to row hangs on \
                 a choice that the paper leaves open, on what reality differs in, or on the few runs.";
    format!(
        "<h3>Under other assumptions</h3>\n<div id=\"sensitivity\">\n{}</div>\n",
        table("", words, &head, &rows)
    )
}

fn assumed(one: &Assumed) -> Row {
    let what = format!(
        "<code>{}</code><br/><span class=\"small\">{}</span>",
        escaped(&one.arm.name),
        escaped(&one.arm.words)
    );
    let verdicts = one.claims.iter().map(|claim| match claim.verdict {
        Verdict::Reproduced => Cell::html(chip(claim.verdict, "yes")),
        Verdict::NotReproduced => Cell::html(chip(claim.verdict, "no")),
        Verdict::Undecided | Verdict::NotMeasured => Cell::html(chip(claim.verdict, NONE)),
    });
    Row {
        cells: std::iter::once(Cell::html(what)).chain(verdicts).collect(),
        sum: false,
    }
}

/// Words on a verdict's background colour.
fn chip(verdict: Verdict, words: &str) -> String {
    format!("<span class=\"chip {}\">{words}</span>", class(verdict))
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "reproduced",
        Verdict::NotReproduced => "not-reproduced",
        Verdict::Undecided | Verdict::NotMeasured => "undecided",
    }
}

fn words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "reproduced",
        Verdict::NotReproduced => "not reproduced",
        Verdict::Undecided => "undecided",
        Verdict::NotMeasured => "not measured",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::page::check::unbalanced;
    use crate::studies::file::{MIGLINO1995, StudyFile};

    fn claims(verdicts: [Verdict; 3]) -> Vec<Claim> {
        let claim = |(number, verdict): (usize, Verdict)| Claim {
            id: format!("C{number}"),
            question: "transfer".into(),
            statement: "Robots <do>.".into(),
            source: "section 4".into(),
            criterion: "They do.".into(),
            unit: "runs".into(),
            verdict,
            effects: Vec::new(),
            tests: Vec::new(),
            remark: String::new(),
        };
        verdicts.into_iter().enumerate().map(claim).collect()
    }

    #[test]
    fn claims_stand_by_assumption_below_what_these_are_about() {
        use Verdict::{NotReproduced, Reproduced, Undecided};
        let assumed = |arm: Arm, first| Assumed {
            arm,
            claims: claims([first, NotReproduced, Undecided]),
        };
        let groups = StudyFile::open(&MIGLINO1995, None).unwrap().groups().unwrap();
        let arms = Sensitivity {
            main: assumed(Arm::main(), Reproduced),
            groups: groups
                .into_iter()
                .map(|group| {
                    let shown = ["ten-readings", "interpolated", "only-read-noise"];
                    let own = group.arms.into_iter().filter(|arm| shown.contains(&arm.name.as_str()));
                    (group.about, own.map(|arm| assumed(arm, NotReproduced)).collect())
                })
                .collect(),
        };
        let section = by_assumption(&arms);
        assert_eq!(unbalanced(&section), None);
        assert_eq!(section.matches(">yes</span>").count(), 1);
        assert_eq!(section.matches(">no</span>").count(), 1 + 3 * 2);
        assert!(
            section.contains("<td>1/4</td>") && section.contains("<td>0/4</td>") && section.contains("<td>0/0</td>")
        );
        let kinds: Vec<&str> = section.split("<tr class=\"sum\">").collect();
        assert_eq!(kinds.len(), 1 + 2 + 1, "two kinds with arms and the last row");
        assert!(kinds[1].contains("its samples") && kinds[1].contains("mean of ten turns"));
        assert!(kinds[1].contains("<code>ten-readings</code>") && kinds[1].contains("<code>interpolated</code>"));
        assert!(kinds[2].contains("one difference") && kinds[2].contains("<code>only-read-noise</code>"));
        assert!(kinds[2].contains("Reality differs in read noise alone"));
    }
}
