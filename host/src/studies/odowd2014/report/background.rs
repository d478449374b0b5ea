//! Background of the study: its facts, its assumptions, and the paper's slips.

use super::{Report, credit_words, paper};
use crate::report::numbers::shown;
use crate::report::page::{self, Section, facts as facts_html, list};
use crate::studies::assumptions;

const DIGITS: usize = 4;

/// The facts below the title, as HTML.
pub(super) fn facts(study: &Report<'_>) -> String {
    let results = study.results;
    let combinations: Vec<String> = results
        .combinations
        .iter()
        .map(|one| format!("{} with {}", shown(one.scale, DIGITS), credit_words(one.credit)))
        .collect();
    let facts = [
        ("robots", results.robots.to_string()),
        ("a run", format!("{} minutes", results.minutes)),
        (
            "the light",
            format!("moves after {} minutes, where it does", results.light_moves_minute),
        ),
        ("runs", format!("{} of each case and kind", results.runs)),
        ("mutations, s.d.", combinations.join("; ")),
        ("seed", study.seed.to_string()),
    ];
    format!(
        "<p class=\"lead\">\u{201c}The distributed co-evolution of an on-board simulator and controller for swarm robot \
         behaviours\u{201d}, Evolutionary Intelligence 7(2), 2014, done again: controllers evolve on board of foraging \
         robots, in simulators that evolve among the robots that meet, and each claim of the paper is held against what \
         came out.</p>\n{}",
        facts_html(&facts)
    )
}

pub(super) fn section(study: &Report<'_>) -> Section {
    let body = [
        assumptions::html(study.assumptions),
        "<h3>Slips of the paper</h3>\n".to_owned(),
        list(&paper::SLIPS),
        page::paragraph(
            "Figures 1 to 4 are drawn anew from what the paper says of them; where it leaves a size open, it is the one in \
             force here.",
        ),
    ];
    Section {
        id: "background".into(),
        title: "Assumptions, and slips of the paper".into(),
        body: body.concat(),
    }
}
