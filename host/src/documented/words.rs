//! Tests: texts for users have one word for each thing (CONTRIBUTING.md, "Words"). With `ONEIRO_MESSAGES=FILE` all texts are written to
//! that file, for a person to read.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::imports::{crates, modules, root, tokens, without_tests};

/// Words that texts do not have. `greatest` and `least` are `maximum` and `minimum`, except in `at least`.
const OLD: [&str; 28] = [
    "life",
    "lives",
    "rollout",
    "rollouts",
    "contest",
    "contests",
    "described robot",
    "described robots",
    "described wheels",
    "in place of",
    "in its place",
    "in their place",
    "on a wire",
    "on wires",
    "of its own",
    "of their own",
    "of your own",
    "of one's own",
    "greatest",
    "least",
    "share of",
    "shares of",
    "sooner",
    "nothing but",
    "all but",
    "as it is",
    "as it stands",
    "as they are",
];

/// Files that may have such words, and why.
const EXCEPTIONS: [(&str, &str); 6] = [
    (
        "host/lab/src/reality/described.rs",
        "the robot's name in directories of samples, by which `oneiro robot sample` continues them",
    ),
    (
        "host/studies/src/miglino1995/judge.rs",
        "names of figures, by which claims.toml and published tables give the paper's",
    ),
    ("host/studies/src/odowd2014/judge.rs", "names of figures, the same"),
    (
        "host/studies/src/miglino1995/report/background.rs",
        "Artificial Life is a journal",
    ),
    (
        "src/parts/compose/part/fields.rs",
        "LEAST to GREATEST is the form of comments in users' parts",
    ),
    ("host/src/api/evaluate.rs", "lives is an argument in Python"),
];

/// A literal's words in small letters, without names in backquotes, values in braces, `at least` and punctuation.
fn words(literal: &str) -> String {
    // A line that goes on has its blank before the mark.
    let mut lines = literal.split("\\\n");
    let mut text = lines.next().unwrap_or_default().to_owned();
    for line in lines {
        text.push_str(line.trim_start());
    }
    let text: String = text.split('`').step_by(2).collect::<Vec<_>>().join(" ");
    let mut depth = 0_usize;
    let kept = text.chars().filter(|c| {
        depth += usize::from(*c == '{');
        let is_kept = depth == 0;
        depth = depth.saturating_sub(usize::from(*c == '}'));
        is_kept
    });
    let kept: String = kept.collect::<String>().to_lowercase();
    let words = kept
        .split_whitespace()
        .map(|word| word.trim_matches(|c: char| ".,;:!?()[]\"\\".contains(c)));
    words.collect::<Vec<_>>().join(" ").replace("at least", "")
}

/// The first old word of a literal with several words.
fn old_word(literal: &str) -> Option<&'static str> {
    let words = format!(" {} ", words(literal));
    let has = |old: &&&str| words.contains(&format!(" {old} "));
    OLD.iter()
        .find(has)
        .copied()
        .filter(|_| literal.trim_matches('"').contains(' '))
}

#[test]
fn old_words_are_found() {
    for (literal, expected) in [
        ("\"a share of {life}\"", Some("share of")),
        ("r\"the greatest, at least\"", Some("greatest")),
        ("\"at least {least}, `lives` in lives.csv by --lives\"", None),
        ("\"one life\"", Some("life")),
        ("\"robots on \\\n     wires.\"", Some("on wires")),
        ("\"lives\"", None),
    ] {
        assert_eq!(old_word(literal), expected, "{literal}");
    }
}

#[test]
fn texts_have_one_word_for_each_thing() {
    let (mut problems, mut excepted, mut messages) = (Vec::new(), BTreeSet::new(), String::new());
    let root = root();
    for source in crates()
        .into_iter()
        .chain([root.clone()])
        .map(|folder| folder.join("src"))
    {
        let mut all = BTreeMap::new();
        modules(&source, &source, &mut all);
        let files: Vec<_> = all
            .iter()
            .map(|(module, path)| (module, path, without_tests(&tokens(&fs::read_to_string(path).unwrap()))))
            .collect();
        let of_tests: Vec<Vec<String>> = files
            .iter()
            .flat_map(|(module, _, (_, tests))| {
                tests
                    .iter()
                    .map(|name| [&module[..], std::slice::from_ref(name)].concat())
            })
            .collect();
        for (module, path, (tokens, _)) in &files {
            if of_tests.iter().any(|tests| module.starts_with(tests)) {
                continue;
            }
            let path = path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
            let literals = tokens
                .iter()
                .filter(|(token, _)| token.ends_with(['"', '#']) && token.contains('"'));
            for (literal, line) in literals {
                if literal.contains(' ') {
                    messages.extend([path.as_str(), ":", &line.to_string(), ": ", literal, "\n"]);
                }
                let Some(old) = old_word(literal) else { continue };
                match EXCEPTIONS.iter().find(|(file, _)| *file == path) {
                    Some((file, _)) => _ = excepted.insert(*file),
                    None => problems.push(format!("{path}:{line}: `{old}` in {literal}")),
                }
            }
        }
    }
    if let Some(file) = std::env::var_os("ONEIRO_MESSAGES") {
        fs::write(file, messages).unwrap();
    }
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
    assert_eq!(
        excepted.len(),
        EXCEPTIONS.len(),
        "an exception is not needed: {excepted:?}"
    );
}
