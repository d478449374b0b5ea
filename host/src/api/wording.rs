//! Messages name commands and their options. Callers of functions read the functions and arguments that do the same instead. Places,
//! such as `--set KEY=VALUE`, stay as the program prints them.

/// Commands, longest first, and the functions that do the same.
const FUNCTIONS: [(&str, &str); 7] = [
    ("oneiro sweep merge", "oneiro.merge"),
    ("oneiro sweep run", "oneiro.sweep"),
    ("oneiro device test", "oneiro.selftest"),
    ("oneiro evaluate", "oneiro.evaluate"),
    ("oneiro resume", "oneiro.resume"),
    ("oneiro verify", "Run.verify"),
    ("oneiro run", "oneiro.run"),
];

/// Other words of the command line, and those of calls.
const WORDS: [(&str, &str); 5] = [
    ("run the same command", "make the same call"),
    ("the same command", "the same call"),
    (" with --out", " as `out`"),
    ("--backend null: answers", "backend null: answers"),
    ("fewer --threads, or --backend cpu, which", "backend=\"cpu\", which"),
];

/// A message in the words of calls.
pub(super) fn of_calls(message: &str) -> String {
    let text = WORDS
        .iter()
        .fold(message.to_owned(), |text, (word, own)| text.replace(word, own));
    text.split('\n').map(functions).collect::<Vec<_>>().join("\n")
}

/// A line with functions instead of commands.
fn functions(line: &str) -> String {
    let mut text = line.to_owned();
    for (command, function) in FUNCTIONS {
        while let Some(start) = text.find(command) {
            let end = start + command.len();
            // A command's arguments end with its quotation, the line or the sentence, or before what a line adds in brackets.
            let rest = &text[end..];
            let stops = ["`", "; ", ", ", "  ("].into_iter();
            let given = stops.filter_map(|stop| rest.find(stop)).min();
            let given = &rest[..given.unwrap_or(rest.len())];
            let mut arguments = given.strip_prefix(' ').into_iter().flat_map(|given| given.split(" --"));
            let argument = arguments.next().map(|word| word.trim_matches('\''));
            let out = arguments.find_map(|option| option.strip_prefix("out "));
            let out = out.map_or_else(String::new, |out| format!(", out={:?}", out.trim_matches('\'')));
            let call = match argument {
                Some(argument) if !argument.contains(' ') => format!("{function}({argument:?}{out})"),
                // The sentence goes on.
                _ if given.starts_with(' ') => format!("{function}{given}"),
                _ => function.to_owned(),
            };
            text.replace_range(start..end + given.len(), &call);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_calls() {
        for (message, expected) in [
            (
                "stopped; to continue:\n  oneiro resume a/b  (generation 3)",
                "stopped; to continue:\n  oneiro.resume(\"a/b\")  (generation 3)",
            ),
            (
                "a: holds a run; go on with it: oneiro resume a",
                "a: holds a run; go on with it: oneiro.resume(\"a\")",
            ),
            (
                "`oneiro resume` finishes a run, the same command a sweep",
                "`oneiro.resume` finishes a run, the same call a sweep",
            ),
            (
                "a: is a sweep: oneiro sweep run a --out DIR",
                "a: is a sweep: oneiro.sweep(\"a\", out=\"DIR\")",
            ),
            (
                "`oneiro sweep merge d` writes both",
                "`oneiro.merge(\"d\")` writes both",
            ),
            (
                "a: holds files; name another directory with --out",
                "a: holds files; name another directory as `out`",
            ),
            (
                "stopped; run the same command again",
                "stopped; make the same call again",
            ),
            ("--set a=1: unknown key", "--set a=1: unknown key"),
            ("nothing to say", "nothing to say"),
        ] {
            assert_eq!(of_calls(message), expected);
        }
    }
}
