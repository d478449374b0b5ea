//! A study's claims as its report has them: an abstract, a section for each question with the evidence for each verdict, the
//! verdicts under other assumptions, and a glossary.

use std::fmt::Write;

use oneiro_base::console::counted;
use oneiro_report::figures::escaped;
use oneiro_report::numbers::{Digits, NONE, percent, probability, shown};
use oneiro_report::page::{Cell, Head, Row, Section, id, joined, paragraph, table};

use crate::claims::{Claim, Effect, MET_IN, Power, RESAMPLES, Table, Test};
use crate::file::Arm;
use crate::verdict::Verdict;

/// Significant digits of effects and statistics.
const DIGITS: Digits = Digits::Four;

/// All verdicts, from the best to the worst.
const VERDICTS: [Verdict; 4] = [Verdict::Holds, Verdict::Undecided, Verdict::Opposed, Verdict::NotJudged];

/// The answer first: how many claims hold, which ones by question, and a table of their main effects. `about` is a
/// paragraph on the study, as HTML.
pub(super) fn summary(table_of: &Table, claims: &[Claim], about: &str) -> Section {
    let count = |verdict| claims.iter().filter(|claim| claim.verdict == verdict).count();
    let tally = joined(&VERDICTS, |&verdict| match (verdict, count(verdict)) {
        (Verdict::NotJudged, 0) => String::new(),
        (_, count) => format!("<span class=\"{verdict}\"><b>{count}</b>{verdict}</span>\n"),
    });
    let has_power = claims.iter().any(|claim| claim.power.is_some());
    let mut head = vec![
        Head::Text("Claim"),
        Head::Text("What the paper says"),
        Head::Text("Verdict"),
    ];
    if has_power {
        head.extend([Head::Text("30 robots"), Head::Number("chance")]);
    }
    head.extend([
        Head::Text("Main effect"),
        Head::Number("here"),
        Head::Number("95 % interval"),
        Head::Number("paper"),
    ]);
    let (mut answers, mut rows) = (String::new(), Vec::new());
    for (key, question) in table_of.questions() {
        let of_question: Vec<&Claim> = claims.iter().filter(|claim| claim.question == key).collect();
        let answer: Vec<String> = VERDICTS
            .iter()
            .filter_map(|&verdict| answer(verdict, &of_question))
            .collect();
        let (words, answer) = (escaped(question), answer.join("; "));
        let _ = writeln!(answers, "<li><a href=\"#{key}\">{words}</a> {answer}.</li>");
        rows.push(Row {
            cells: vec![Cell::across(head.len(), question)],
            sum: true,
        });
        rows.extend(of_question.into_iter().map(|claim| Row::from(line(claim, has_power))));
    }
    let not_judged = match count(Verdict::NotJudged) {
        0 => String::new(),
        count => format!("; {} not judged", counted(count, "is", "are")),
    };
    let later: Vec<&str> = claims
        .iter()
        .filter(|claim| claim.is_later)
        .map(|claim| claim.id.as_str())
        .collect();
    let fixed = if later.is_empty() {
        "a criterion that was registered before the runs of its edition is met".to_owned()
    } else {
        format!(
            "its criterion is met. Those of {} were written when results were known, the others before",
            later.join(", ")
        )
    };
    let introduction = paragraph(&format!(
        "Of the paper's {}, {}, {} and {}{not_judged}: the 95 % intervals over runs decide whether {fixed}. By question:",
        counted(claims.len(), "claim", "claims"),
        counted(count(Verdict::Holds), "holds", "hold"),
        counted(count(Verdict::Opposed), "is opposed", "are opposed"),
        counted(count(Verdict::Undecided), "is undecided", "are undecided"),
    ));
    let of_power = if has_power {
        " \u{201c}30 robots\u{201d}: the verdict of 8 runs of each of 30 robots in the same simulator; \u{201c}chance\u{201d}: how often \
         five runs of one of these robots give it."
    } else {
        ""
    };
    let caption = format!(
        "All claims with their main effects, next to the paper's figure where it prints one, or where one follows from what it \
         prints. Intervals are over runs.{of_power}"
    );
    let answers = if claims.is_empty() {
        paragraph("Nothing has been judged.")
    } else {
        format!(
            "{introduction}<ul>\n{answers}</ul>\n<div class=\"tally\">\n{tally}</div>\n{}",
            table("", &caption, &head, &rows)
        )
    };
    Section::new("abstract", "Abstract", format!("{about}{answers}"))
}

/// The claims among some that have a verdict, such as `holds: C1, C2`.
fn answer(verdict: Verdict, claims: &[&Claim]) -> Option<String> {
    let with_verdict = claims.iter().filter(|claim| claim.verdict == verdict);
    let links: Vec<String> = with_verdict.map(|claim| link(claim)).collect();
    (!links.is_empty()).then(|| format!("{verdict}: {}", links.join(", ")))
}

fn link(claim: &Claim) -> String {
    format!("<a href=\"#{}\">{}</a>", id(&claim.id), escaped(&claim.id))
}

fn line(claim: &Claim, has_power: bool) -> Vec<Cell> {
    // A claim judged in several combinations has no single combination as its main effect. Otherwise effects that can
    // be compared with the paper come first.
    let effects = &claim.effects;
    let scope = effects.first().filter(|effect| effect.name.starts_with(MET_IN));
    let main = scope
        .or_else(|| effects.iter().find(|effect| effect.paper.is_some()))
        .or(effects.first());
    let mut cells = vec![
        Cell::html(link(claim)),
        Cell::text(&claim.statement),
        Cell::html(chip(claim.verdict, claim.verdict.word())),
    ];
    if has_power {
        let [robots, chance] = power(claim.power);
        cells.extend([Cell::text(&robots), Cell::number(chance)]);
    }
    cells.extend(main.map_or_else(|| vec![Cell::across(4, NONE)], effect));
    cells
}

/// The verdict of many robots, and the chance that five runs of one of them give it.
pub(crate) fn power(power: Option<Power>) -> [String; 2] {
    let none = || NONE.to_owned();
    [
        power.map_or_else(none, |power| power.verdict.to_string()),
        power
            .and_then(|power| power.chance())
            .map_or_else(none, |chance| format!("{} %", percent(chance))),
    ]
}

/// A section for each question: its claims in detail, and the figures and tables that `evidence` has for its key.
pub(super) fn by_question(table: &Table, claims: &[Claim], evidence: impl Fn(&str) -> String) -> Vec<Section> {
    let section = |(key, question): (&str, &str)| {
        let of_question: Vec<&Claim> = claims.iter().filter(|claim| claim.question == key).collect();
        Section::new(
            key.to_owned(),
            question.to_owned(),
            joined(&of_question, |claim| article(claim)) + &evidence(key),
        )
    };
    table.questions().into_iter().map(section).collect()
}

/// How claims were judged, for the methods of every study.
pub(super) fn judging_methods() -> String {
    let paragraphs = [
        "The criterion of each claim was fixed, word for word, before the runs of the edition that has it, unless the claim says otherwise. A run is \
         the unit of analysis unless the paper's test needs another: individuals, robots and minutes of one run depend on each \
         other."
            .to_owned(),
        "A verdict rests on intervals, not on the sign of an estimate. Each part of a criterion compares a figure with \
         a bound. It holds if the figure's 95 % interval over runs lies on the required side. It is opposed if the \
         interval lies on the other side. It is undecided if the interval spans the bound, or if there are fewer than \
         five runs. Comparisons that were registered as tests hold by their p after Holm's correction, and are opposed \
         if the difference has the other sign. A claim holds if all parts hold, and is opposed if one part is. Each \
         claim also says whether the registered criterion is met by the estimates alone."
            .to_owned(),
        "The intervals of verdicts are Student's of run means. Where several conditions enter, they are of differences within run \
         numbers, if conditions share their seeds, as in the second edition of the 1995 study, else Welch's. A ratio is judged as a difference, \
         such as half of one mean minus another. Intervals of d and of recovered shares are those of the jackknife's pseudo-values of runs; \
         intervals of medians lie between order statistics."
            .to_owned(),
        format!(
            "In the tables of effects, the 95 % intervals of means are Student's over runs, those of ratios are by the delta method, and \
             those of d are percentiles of {RESAMPLES} bootstrap samples of runs. Holm's correction covers the tests that a claim or the \
             study names as one family."
        ),
    ];
    format!(
        "<h3>How claims were judged</h3>\n{}",
        joined(&paragraphs, |text| paragraph(text))
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
         <p><b>{}.</b> {}</p>\n<p class=\"small\">The paper: {}. Unit of analysis: {}.</p>\n{}",
        id(&claim.id),
        claim.verdict,
        escaped(&claim.id),
        chip(claim.verdict, claim.verdict.word()),
        escaped(&claim.statement),
        if claim.is_later {
            "Criterion, written when results were known"
        } else {
            "Preregistered"
        },
        escaped(&claim.criterion),
        escaped(&claim.source),
        escaped(&claim.unit),
        verdict_and_reason(claim),
    );
    if let Some(power) = claim.power {
        let Power {
            verdict,
            sets,
            holds,
            undecided,
            opposed,
        } = power;
        let [holds, undecided, opposed] = [holds, undecided, opposed].map(|share| format!("{} %", percent(share)));
        text.push_str(&paragraph(&format!(
            "Eight runs of each of 30 robots say: {verdict}. Of {sets} sets of five runs of one of these robots, in {holds} the claim \
             holds, in {undecided} it is undecided, and in {opposed} it is opposed."
        )));
    }
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

/// The verdict with its reason, and the registered criterion's result, as a paragraph.
fn verdict_and_reason(claim: &Claim) -> String {
    let reasons = claim.reasons.join("; ");
    let in_some = claim.effects.first().filter(|effect| effect.name.starts_with(MET_IN));
    let registered = match (claim.registered, in_some) {
        (Some(true), _) => "is met".to_owned(),
        (Some(false), _) => "is not met".to_owned(),
        (None, Some(effect)) => format!("is met in {} of the combinations", effect.value),
        (None, None) => "can't be evaluated".to_owned(),
    };
    if claim.verdict == Verdict::NotJudged {
        return format!("<p><b>Not judged.</b> {}.</p>\n", escaped(&reasons));
    }
    format!(
        "<p><b>Verdict: {}.</b> {}. By the estimates alone, the registered criterion {registered}.</p>\n",
        claim.verdict,
        escaped(&reasons)
    )
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
    pub arm: Arm,
    pub claims: Vec<Claim>,
}

/// The claims under every assumption.
pub(crate) struct Sensitivity {
    /// The study's main arm.
    pub main: Assumed,
    /// Other arms by subject.
    pub groups: Vec<(String, Vec<Assumed>)>,
}

impl Sensitivity {
    /// All arms, the main arm first.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Assumed> + Clone {
        std::iter::once(&self.main).chain(self.groups.iter().flat_map(|(_, group)| group))
    }
}

/// Table of verdicts by assumption.
pub(super) fn by_assumption(arms: &Sensitivity) -> String {
    let Sensitivity { main, groups } = arms;
    let mut head = vec![Head::Text("Assumption")];
    head.extend(main.claims.iter().map(|claim| Head::Text(&claim.id)));
    let mut rows = vec![row_of_arm(main)];
    for (title, group) in groups.iter().filter(|(_, group)| !group.is_empty()) {
        rows.push(Row {
            cells: vec![Cell::across(head.len(), title)],
            sum: true,
        });
        rows.extend(group.iter().map(row_of_arm));
    }
    let counts = (0..main.claims.len()).map(|column| {
        let asked = arms.all().filter_map(|one| one.claims.get(column));
        let decided = asked.filter(|claim| matches!(claim.verdict, Verdict::Holds | Verdict::Opposed));
        let holds = decided.clone().filter(|claim| claim.verdict == Verdict::Holds);
        Cell::text(&format!("{}/{}", holds.count(), decided.count()))
    });
    rows.push(Row {
        cells: std::iter::once(Cell::text("holds, of those decided"))
            .chain(counts)
            .collect(),
        sum: true,
    });
    let words = "Which claims hold under which assumption. Each row repeats the whole study with one changed choice; \
                 its report is in the directory arms. A verdict that changes from row to row depends on a choice that \
                 the paper leaves open, on reality's differences, or on the few runs.";
    format!(
        "<h3>Under other assumptions</h3>\n<div id=\"sensitivity\">\n{}</div>\n",
        table("", words, &head, &rows)
    )
}

fn row_of_arm(one: &Assumed) -> Row {
    let what = format!(
        "<code>{}</code><br/><span class=\"small\">{}</span>",
        escaped(&one.arm.name),
        escaped(&one.arm.words)
    );
    let verdicts = one.claims.iter().map(|claim| match claim.verdict {
        Verdict::Holds => Cell::html(chip(claim.verdict, "yes")),
        Verdict::Opposed => Cell::html(chip(claim.verdict, "no")),
        Verdict::Undecided | Verdict::NotJudged => Cell::html(chip(claim.verdict, NONE)),
    });
    Row {
        cells: std::iter::once(Cell::html(what)).chain(verdicts).collect(),
        sum: false,
    }
}

/// Words on a verdict's background colour.
fn chip(verdict: Verdict, words: &str) -> String {
    format!("<span class=\"chip {verdict}\">{words}</span>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{Edition, MIGLINO1995, StudyFile};
    use oneiro_report::page::check::unbalanced;

    fn claims(verdicts: [Verdict; 3]) -> Vec<Claim> {
        let claim = |(number, verdict): (usize, Verdict)| Claim {
            id: format!("C{number}"),
            question: "transfer".into(),
            statement: "Robots <do>.".into(),
            source: "section 4".into(),
            criterion: "They do.".into(),
            is_later: false,
            unit: "runs".into(),
            verdict,
            reasons: Vec::new(),
            registered: None,
            effects: Vec::new(),
            tests: Vec::new(),
            power: None,
            remark: String::new(),
        };
        verdicts.into_iter().enumerate().map(claim).collect()
    }

    #[test]
    fn claims_stand_by_assumption_below_what_these_are_about() {
        use Verdict::{Holds, Opposed, Undecided};
        let assumed = |arm: Arm, first| Assumed {
            arm,
            claims: claims([first, Opposed, Undecided]),
        };
        let groups = StudyFile::open(&MIGLINO1995, None)
            .unwrap()
            .in_edition(Edition::First)
            .unwrap()
            .groups()
            .unwrap();
        let arms = Sensitivity {
            main: assumed(Arm::main(), Holds),
            groups: groups
                .into_iter()
                .map(|group| {
                    let shown = ["ten-readings", "interpolated", "only-read-noise"];
                    let arms = group.arms.into_iter().filter(|arm| shown.contains(&arm.name.as_str()));
                    (group.about, arms.map(|arm| assumed(arm, Opposed)).collect())
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
