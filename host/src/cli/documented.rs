//! Whatever documents, experiments, help texts and messages tell a user to type is parsed as the command line would be.

use std::collections::BTreeSet;
use std::path::Path;

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::Cli;
use crate::scratch::holds;

#[path = "../../../tests/program/documented/typed.rs"]
mod typed;

/// A command to type, and its place.
struct Typed {
    place: String,
    words: Vec<String>,
}

/// Parses words as the command line. Those in capitals stand for values.
fn parsed(mut words: Vec<String>) -> Result<(), String> {
    /// Values of the kinds that there are, one of which is tried after the other.
    const VALUES: [&str; 9] = ["1", "1..2", "1/2", "1s", "1,1,0", "on", "a=1", "bash", "0.5"];
    for word in &mut words {
        if word == "STUDY" {
            "miglino1995".clone_into(word);
        }
    }
    let mut tried = 0;
    loop {
        let Err(error) = Cli::command().try_get_matches_from(&words) else {
            return Ok(());
        };
        match error.kind() {
            // A sentence may leave out what is not its subject.
            ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
            | ErrorKind::MissingSubcommand
            | ErrorKind::MissingRequiredArgument => return Ok(()),
            ErrorKind::ValueValidation | ErrorKind::InvalidValue => {
                let Some(ContextValue::String(value)) = error.get(ContextKind::InvalidValue) else {
                    return Err(error.to_string());
                };
                // An option may be named without its value.
                if value.is_empty() {
                    return Ok(());
                }
                let is_for_another =
                    value.chars().any(|c| c.is_ascii_uppercase()) && !value.chars().any(|c| c.is_ascii_lowercase());
                let at = words
                    .iter()
                    .position(|word| word == value || word.ends_with(&format!("={value}")));
                let (Some(at), true, true) = (at, is_for_another || tried > 0, tried < VALUES.len()) else {
                    return Err(error.to_string());
                };
                VALUES[tried].clone_into(&mut words[at]);
                tried += 1;
            }
            _ => return Err(error.to_string()),
        }
    }
}

/// A command of a sentence as words: without brackets around what may be left out, and dots for more of the same.
fn in_sentence(span: &str) -> Vec<String> {
    let plain = |word: String| match word.strip_prefix('[') {
        // A list's value has its own brackets.
        Some(word) if !word.ends_with(']') || !word.contains(',') => word.trim_end_matches(']').to_owned(),
        _ if !word.contains('[') => word.trim_end_matches(']').to_owned(),
        _ => word,
    };
    let words = typed::of_program(&span.replace(['\n', ';'], " "));
    let words = words.into_iter().flatten().map(plain);
    words
        .filter(|word| !["..", "...", ""].contains(&word.as_str()))
        .collect()
}

/// Commands in a page: its blocks, and the code in its sentences.
fn of_page(name: &str, page: &str) -> Vec<Typed> {
    let (blocks, rest) = typed::blocks(page);
    let mut found = Vec::new();
    for block in &blocks {
        for words in typed::of_program(&block.script().unwrap_or_default()) {
            let place = format!("{name}:{}", block.line);
            found.push(Typed { place, words });
        }
    }
    found.extend(of_sentences(name, &rest));
    found
}

fn of_sentences(name: &str, text: &str) -> Vec<Typed> {
    let spans = typed::inline(text).into_iter();
    let spans = spans.filter(|(_, span)| span.starts_with("oneiro ") || span.starts_with("oneiro\n"));
    spans
        .map(|(line, span)| Typed {
            place: format!("{name}:{line}"),
            words: in_sentence(span),
        })
        .collect()
}

/// Commands in the comments of a script or an experiment: indented lines, and the code in sentences.
fn of_comments(name: &str, text: &str, mark: &str) -> Vec<Typed> {
    let comments: String = text
        .lines()
        .map(|line| line.trim_start().strip_prefix(mark).unwrap_or_default().to_owned() + "\n")
        .collect();
    let mut found = of_sentences(name, &comments);
    for (line, number) in comments.lines().zip(1..) {
        for words in typed::of_program(line.trim_start())
            .into_iter()
            .filter(|_| line.starts_with("    "))
        {
            let place = format!("{name}:{number}");
            found.push(Typed { place, words });
        }
    }
    found
}

/// Commands in the texts of a source: its messages and its comments, between backquotes or after a colon.
fn of_source(name: &str, source: &str) -> Vec<Typed> {
    let source = source.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let mut text = String::new();
    for line in source.lines() {
        let line = line.trim_start();
        let line = line
            .trim_start_matches("//!")
            .trim_start_matches("///")
            .trim_start_matches("//");
        // Literals go on after a backslash.
        text += line.strip_suffix('\\').unwrap_or(line);
        if !line.ends_with('\\') {
            text += " ";
        }
    }
    // Values that a message has.
    let mut plain = String::new();
    let mut depth = 0;
    for character in text.chars() {
        match character {
            '{' => depth += 1,
            '}' if depth > 0 => {
                depth -= 1;
                if depth == 0 {
                    plain.push('X');
                }
            }
            other if depth == 0 => plain.push(other),
            _ => {}
        }
    }
    let plain = plain.replace("cargo run --release -- ", "oneiro ");
    let commands: BTreeSet<String> = Cli::command()
        .get_subcommands()
        .map(|own| own.get_name().to_owned())
        .collect();
    let mut found = Vec::new();
    for (at, _) in plain.match_indices("oneiro ") {
        let before = plain[..at].chars().next_back().unwrap_or(' ');
        let after = &plain[at..];
        let first = after.split([' ', '`', '"', '<']).nth(1).unwrap_or_default();
        let span = match before {
            '`' => after.split('`').next().unwrap_or_default(),
            ' ' | '>' | '(' if commands.contains(first) => unquoted(after),
            _ => continue,
        };
        // Code, rather than a command: it goes on over lines.
        if span.len() < 200 {
            let words = in_sentence(span);
            found.push(Typed {
                place: name.to_owned(),
                words,
            });
        }
    }
    found
}

/// The part of a sentence that is a command, which nothing ends: as long as its words look like those of one.
fn unquoted(text: &str) -> &str {
    let mut end = 0;
    let program = Cli::command();
    let mut command = &program;
    for (index, word) in text.split_inclusive(' ').enumerate() {
        let bare = word.trim_end();
        let named = command.find_subcommand(bare);
        let looks = index == 0
            || named.is_some()
            || bare.starts_with('-')
            || bare.starts_with(|c: char| c.is_ascii_uppercase() || c.is_ascii_digit())
            || bare.contains(['/', '=']);
        if !looks {
            break;
        }
        command = named.unwrap_or(command);
        let cut = bare.find(['"', '<', ';', ',', ')', '`']);
        end += cut.unwrap_or(word.len());
        if cut.is_some() {
            break;
        }
    }
    text[..end].trim_end()
}

/// All commands of the repository.
fn all() -> Vec<Typed> {
    let mut found = Vec::new();
    for path in typed::files(&["md", "toml", "py", "pyi", "ipynb", "rs", "sh", "service"]) {
        let name = path.display().to_string();
        let is_test = path.starts_with("tests") || name.contains("tests") || path.ends_with("documented.rs");
        if path.ends_with("CHANGELOG.md") || is_test && path.extension().is_none_or(|own| own != "md") {
            continue;
        }
        let text = typed::text(&path);
        found.extend(match path.extension().and_then(|extension| extension.to_str()) {
            Some("md") => of_page(&name, &text),
            Some("rs") => of_source(&name, &text),
            Some("ipynb") => of_sentences(&name, &text.replace("\\n\",", " ").replace("\\\"", "\"")),
            Some("pyi" | "py") => [of_comments(&name, &text, "#"), of_sentences(&name, &text)]
                .into_iter()
                .flatten()
                .collect(),
            _ => of_comments(&name, &text, "#"),
        });
    }
    let mut program = Cli::command();
    program.build();
    let mut commands = vec![program];
    while let Some(mut command) = commands.pop() {
        let help = command.render_long_help().to_string();
        found.extend(of_sentences(&format!("help of {}", command.get_name()), &help));
        commands.extend(command.get_subcommands().cloned());
    }
    found
}

#[test]
fn what_is_written_to_be_typed_is_a_command_line() {
    let all = all();
    let wrong: Vec<String> = all
        .iter()
        .filter_map(|typed| {
            let problem = parsed(typed.words.clone()).err()?;
            Some(format!(
                "{}: {}\n    {}",
                typed.place,
                typed.words.join(" "),
                problem.lines().next().unwrap_or_default()
            ))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let of = |part: &str| all.iter().filter(|typed| typed.place.contains(part)).count();
    for (part, least) in [
        ("README.md", 3),
        ("docs/", 250),
        ("experiments/", 30),
        ("host/", 100),
        ("help of", 10),
        ("python/", 5),
    ] {
        assert!(of(part) >= least, "{part}: {}", of(part));
    }
}

/// Controls: mistakes of each kind, in each kind of place.
#[test]
fn what_is_no_command_line_is_noticed() {
    let block = |command: &str| of_page("page", &format!("A page.\n\n```sh\n{command}\n```\n"));
    let sentence = |command: &str| of_page("page", &format!("Type `{command}`.\n"));
    let comment = |command: &str| of_comments("file", &format!("# Type:\n#     {command}\nkey = 1\n"), "#");
    let message = |command: &str| {
        of_source(
            "source",
            &format!("let message = \"is a sweep; `{command}` runs it\";\n"),
        )
    };
    let bare = |command: &str| of_source("source", &format!("format!(\"no run: {command}\")\n"));
    for wrong in [
        "oneiro run X.toml --sede 1",
        "oneiro sweep runn X.toml",
        "oneiro sweep run X.toml --shard 3",
        "oneiro verify RUN --recompute --fraction 1.5",
        "oneiro run X.toml --seed 1 --seeds 1..3",
    ] {
        for found in [block(wrong), sentence(wrong), comment(wrong), message(wrong)] {
            assert_eq!(found.len(), 1, "{wrong}");
            parsed(found[0].words.clone()).expect_err(wrong);
        }
        // Without quotes a sentence may go on after the name of a command.
        if !wrong.contains("runn") {
            parsed(bare(wrong)[0].words.clone()).expect_err(wrong);
        }
    }
    for right in [
        "oneiro run X.toml --seed N --out DIR",
        "oneiro sweep run X.toml --shard I/N --time-budget TIME",
        "oneiro evaluate --genomes F --log DIR --robot ADDRESS",
    ] {
        for found in [
            block(right),
            sentence(right),
            comment(right),
            message(right),
            bare(right),
        ] {
            assert_eq!(parsed(found[0].words.clone()), Ok(()), "{right}");
        }
    }
    let control = "for seed in $(seq 1 100); do oneiro fleet twin fleet.toml --seed $seed --out twins/$seed; done\n";
    assert_eq!(
        block(control)[0].words.join(" "),
        "oneiro fleet twin fleet.toml --seed 1 --out twins/1"
    );
}

/// Options of other programs that documents name: Cargo's, scripts', and words of `AutoMoDe`'s texts.
const OTHERS: [&str; 14] = [
    "features",
    "profile",
    "no-default-features",
    "test",
    "with-learning",
    "ignored",
    "include-ignored",
    "nstates",
    "nroot",
    "rwm",
    "att",
    "rep",
    "p",
    "w",
];

/// Options that a page names without their command are options of some command.
#[test]
fn options_in_documents_are_options() {
    let mut known = BTreeSet::new();
    let mut commands = vec![Cli::command()];
    while let Some(mut command) = commands.pop() {
        command.build();
        known.extend(
            command
                .get_arguments()
                .filter_map(|own| own.get_long())
                .map(str::to_owned),
        );
        commands.extend(command.get_subcommands().cloned());
    }
    let mut wrong = Vec::new();
    let mut named = 0;
    for (place, span) in typed::spans() {
        let Some(option) = span.strip_prefix("--") else {
            continue;
        };
        let option = option.split([' ', '=', '\n']).next().unwrap_or_default();
        let is_word = !option.is_empty() && option.chars().all(|c| c.is_ascii_lowercase() || c == '-');
        if is_word && !OTHERS.contains(&option) {
            named += 1;
            if !known.contains(option) {
                wrong.push(format!("{place}: --{option}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(named > 50, "{named}");
}

/// Options of at least so many commands are on the page once.
const COMMON: usize = 8;

/// A command and its name in full.
struct Named {
    name: String,
    command: clap::Command,
}

/// All commands that the help shows, each before its sub-commands, in the order of the help.
fn named_commands() -> Vec<Named> {
    fn add(name: &str, command: &clap::Command, found: &mut Vec<Named>) {
        let name = format!("{name} {}", command.get_name());
        found.push(Named {
            name: name.trim().to_owned(),
            command: command.clone(),
        });
        let shown = command
            .get_subcommands()
            .filter(|own| !own.is_hide_set() && own.get_name() != "help");
        shown.for_each(|own| add(name.trim(), own, found));
    }
    let mut program = super::command();
    program.build();
    let mut found = Vec::new();
    add("", &program, &mut found);
    found
}

/// Text of a help in a page.
fn in_page(text: &str) -> String {
    let part = |(index, part): (usize, &str)| {
        let part = part.replace('|', "\\|");
        if index % 2 == 1 {
            return format!("`{part}`");
        }
        part.replace('<', "&lt;").replace('*', "\\*").replace('[', "\\[")
    };
    let escaped: String = text.split('`').enumerate().map(part).collect();
    escaped.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// An argument's row: how it is typed, what it means, its words and its default.
fn row(argument: &clap::Arg) -> String {
    let values: Vec<String> = argument
        .get_value_names()
        .unwrap_or_default()
        .iter()
        .map(ToString::to_string)
        .collect();
    let takes = argument.get_action().takes_values();
    let dots = match argument.get_num_args() {
        Some(range) if range.max_values() > 1 => " ..",
        _ => "",
    };
    let value = if takes { values.join(" ") + dots } else { String::new() };
    let typed = match (argument.get_long(), argument.get_short()) {
        (Some(long), Some(short)) => format!("--{long}`, `-{short} {value}"),
        (Some(long), None) => format!("--{long} {value}"),
        (None, _) => value,
    };
    let help = argument
        .get_long_help()
        .or(argument.get_help())
        .map(ToString::to_string)
        .unwrap_or_default();
    let words = argument
        .get_possible_values()
        .into_iter()
        .filter(|own| !own.is_hide_set() && takes);
    let words: Vec<String> = words
        .map(|own| match own.get_help() {
            Some(help) => format!("`{}` ({})", own.get_name(), in_page(&help.to_string())),
            None => format!("`{}`", own.get_name()),
        })
        .collect();
    let mut cells = vec![in_page(&help)];
    if !words.is_empty() {
        cells.push(format!("Values: {}", words.join(", ")));
    }
    let default: Vec<_> = argument
        .get_default_values()
        .iter()
        .map(|own| own.to_string_lossy())
        .collect();
    if takes && !default.is_empty() && !argument.is_hide_default_value_set() {
        cells.push(format!("Default: `{}`", default.join(",")));
    }
    format!("| `{}` | {} |\n", typed.trim().replace('|', "\\|"), cells.join(". "))
}

/// The reference of commands: each with its arguments, those of many commands first and once.
fn page_of_commands() -> String {
    const TABLE: &str = "\n| argument | meaning |\n|---|---|\n";
    let commands = named_commands();
    let rows = |command: &clap::Command| -> Vec<(Option<String>, String)> {
        let shown = command.get_arguments().filter(|own| !own.is_hide_set());
        let shown = shown.filter(|own| !["help", "version"].contains(&own.get_id().as_str()));
        shown.map(|own| (own.get_long().map(str::to_owned), row(own))).collect()
    };
    let all: Vec<String> = commands
        .iter()
        .flat_map(|own| rows(&own.command))
        .map(|(_, row)| row)
        .collect();
    let is_common = |row: &String| all.iter().filter(|own| *own == row).count() >= COMMON;
    let common: BTreeSet<&String> = all.iter().filter(|row| is_common(row)).collect();
    assert!(!common.is_empty());
    let mut page = vec![format!("\n## Options of many commands\n{TABLE}")];
    page.extend(common.into_iter().cloned());
    for Named { name, command } in commands.iter().skip(1) {
        let about = command
            .get_long_about()
            .or(command.get_about())
            .map(ToString::to_string)
            .unwrap_or_default();
        let about: Vec<String> = about.split("\n\n").map(in_page).collect();
        let level = "#".repeat(name.split(' ').count());
        let usage = command.clone().render_usage().to_string();
        let usage = usage
            .trim_start_matches("Usage: ")
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        page.push(format!(
            "\n{level} `{name}`\n\n{}.\n\n    {usage}\n",
            about.join("\n\n").trim_end_matches('.')
        ));
        let (common, own): (Vec<_>, Vec<_>) = rows(command).into_iter().partition(|(_, row)| is_common(row));
        if !own.is_empty() {
            page.push(TABLE.to_owned());
            page.extend(own.into_iter().map(|(_, row)| row));
        }
        let common: Vec<String> = common
            .into_iter()
            .filter_map(|(long, _)| Some(format!("`--{}`", long?)))
            .collect();
        let global = ["`--json`", "`--quiet`"];
        let common: Vec<String> = common
            .into_iter()
            .filter(|own| !global.contains(&own.as_str()))
            .collect();
        if !common.is_empty() {
            page.push(format!(
                "\nAnd {}: [above](#options-of-many-commands).\n",
                common.join(", ")
            ));
        }
    }
    page.concat()
}

#[test]
#[cfg_attr(not(feature = "twin"), ignore = "the page has all commands")]
fn the_page_of_commands_is_that_of_the_command_line() {
    const MARK: &str = "move it here. -->\n";
    let path = typed::root().join("docs/commands.md");
    let text = typed::text(Path::new("docs/commands.md"));
    let (head, _) = text.split_once(MARK).unwrap();
    holds(&path, &format!("{head}{MARK}{}", page_of_commands())).unwrap();
}
