//! `oneiro check --explain`: the rules that an experiment's own parts keep.

use oneiro::compose::Rule;
use oneiro::parameter::nearest;
use oneiro_base::answer::Answer;
use oneiro_base::console::columns;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::experiment::values::instead;
use serde_json::{Value, json};

use crate::cli::ALL_RULES;

/// Characters of a line.
const WIDTH: usize = 100;

/// Explains a rule, or lists all.
///
/// # Errors
/// Exit 3: there is no such rule.
pub(crate) fn explain(name: &str) -> Result<Answer> {
    if name == ALL_RULES {
        return Ok(list());
    }
    // As a refusal shows it.
    let name = name.trim_matches(['[', ']']);
    if let Some(rule) = Rule::ALL.iter().find(|rule| rule.name() == name) {
        return Ok(Answer::new(text(*rule), value(*rule)));
    }
    let names: Vec<_> = Rule::ALL.iter().map(|rule| rule.name()).collect();
    Err(Failure::input(format_args!(
        "--explain: there is no rule `{name}`{}",
        instead(
            nearest(names.iter().copied(), name),
            &format!("{}, or {ALL_RULES} for what each says", names.join(", "))
        )
    )))
}

fn list() -> Answer {
    let rows = Rule::ALL
        .iter()
        .map(|rule| vec![rule.name().to_owned(), rule.about().to_owned()]);
    Answer::new(
        columns(&["rule", "meaning"], &rows.collect::<Vec<_>>()),
        Rule::ALL.iter().map(|rule| value(*rule)).collect(),
    )
}

fn value(rule: Rule) -> Value {
    let [wrong, right] = rule.examples().map_or([None; 2], |examples| examples.map(Some));
    json!({ "rule": rule.name(), "meaning": rule.about(), "why": rule.why(), "wrong": wrong, "right": right })
}

fn text(rule: Rule) -> String {
    let paragraphs = [format!("{}: {}", rule.name(), rule.about()), rule.why().to_owned()];
    let paragraphs = paragraphs.map(|paragraph| filled(&paragraph));
    let examples = ["Wrong", "Right"]
        .into_iter()
        .zip(rule.examples().into_iter().flatten());
    let examples = examples.map(|(title, example)| {
        let lines = example.lines().map(|line| format!("\n    {line}"));
        format!("{title}:\n{}", lines.collect::<String>())
    });
    paragraphs.into_iter().chain(examples).collect::<Vec<_>>().join("\n\n")
}

/// A paragraph in lines of at most [`WIDTH`] characters.
fn filled(paragraph: &str) -> String {
    let mut lines = vec![String::new()];
    for word in paragraph.split(' ') {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDTH => line.extend([" ", word]),
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_are_filled() {
        let long = "word ".repeat(100);
        let lines = filled(long.trim_end());
        assert!(lines.lines().all(|line| line.len() <= WIDTH));
        assert_eq!(lines.split_whitespace().count(), 100);
        assert_eq!(lines.lines().count(), 5);
        assert_eq!(filled("a b"), "a b");
    }

    #[cfg(feature = "compose")]
    #[test]
    fn the_page_on_rules_is_that_of_the_compiler() {
        use std::path::Path;
        const MARK: &str = "move it here. -->\n";
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/rules.md");
        let page = std::fs::read_to_string(&path).unwrap();
        let (head, _) = page.split_once(MARK).unwrap();
        let rows = Rule::ALL
            .iter()
            .map(|rule| format!("| `{rule}` | {} |\n", rule.about()));
        let page = format!(
            "{head}{MARK}\n| rule | meaning |\n|---|---|\n{}",
            rows.collect::<String>()
        );
        // A screen.
        assert!(page.lines().count() <= 45 && page.lines().all(|line| line.chars().count() <= 140));
        crate::scratch::holds(&path, &page).unwrap();
    }
}
