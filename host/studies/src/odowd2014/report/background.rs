//! The study's methods and limits.

use oneiro_report::numbers::{Digits, shown};
use oneiro_report::page::{self, Section, list, paragraph};

use super::{Report, credit_words, paper, system};
use crate::{assumptions, verdicts};

const DIGITS: Digits = Digits::Four;

/// The study's subject, as HTML.
pub(super) const ABOUT: &str = "<p class=\"lead\">\u{201c}The distributed co-evolution of an on-board simulator and \
     controller for swarm robot behaviours\u{201d}, Evolutionary Intelligence 7(2), 2014, replicated. Controllers \
     evolve on board of foraging robots, in simulators that evolve among the robots that meet. The paper asks whether \
     robots can improve these simulators merely by comparing how well they forage; each of its claims is compared \
     with the results.</p>\n";

pub(super) fn methods(study: &Report<'_>) -> Section {
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
    let words = format!(
        "In each run {} robots forage for {} minutes, in one of six cases: with no light, with one over the nest or \
         opposite it, with one that moves from the one to the other, and moving at random. Each minute a robot \
         evolves a controller in its simulator, whose gene S0 says where the light is, drives by it, and compares its \
         simulator with those of the robots that it meets by the food earned. In the control, food is shuffled among \
         robots before they compare it, so that nothing is selected.",
        results.robots, results.minutes
    );
    let several = "The paper gives a standard deviation of mutations that does not fit its genes, and credits fitness \
                   to a simulator that the controller was not chosen in. So no single setting is the paper's: several \
                   were run, and none has precedence. A claim is reproduced if its criterion holds in all of them.";
    let several = if results.combinations.len() > 1 {
        paragraph(several)
    } else {
        String::new()
    };
    let body = [
        paragraph(&words),
        several,
        page::facts(&facts),
        system::html(study),
        verdicts::judging_methods(),
    ];
    Section::new("methods", "Methods", body.concat())
}

/// The limits of the results.
pub(super) fn limits(study: &Report<'_>) -> Section {
    let body = [
        list(&[
            "Reality is a simulated arena with noise and differences that the on-board simulators lack, and no swarm of e-pucks.",
            "Phototaxis in darkness and the time of a controller's installation are not varied. The second edition of \
             the study varies them, with 100 runs of each case, and contradicts some verdicts of studies like this \
             one (docs/odowd2014.md).",
        ]),
        study.arms.map_or_else(String::new, verdicts::by_assumption),
        "<h3>Slips of the paper</h3>\n".to_owned(),
        list(&paper::SLIPS),
        paragraph(
            "Figures 1 to 4 are redrawn from the paper's description; where it leaves a size open, they have this \
             study's.",
        ),
        assumptions::html(study.assumptions),
    ];
    Section::new("limits", "Limits", body.concat())
}
