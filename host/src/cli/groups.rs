//! The list of commands in the program's help, in groups.

use std::fmt::Write;

use clap::Command;

/// Headings, and the commands under each, in the order of the help.
const GROUPS: [(&str, &[&str]); 4] = [
    (
        "Evolve",
        &["new", "import", "check", "run", "adopt", "resume", "sweep", "reproduce"],
    ),
    (
        "Look at results",
        &["list", "watch", "replay", "evaluate", "compare", "verify"],
    ),
    ("Robots", &["robot", "fleet", "export"]),
    ("This machine", &["device", "completions", "man"]),
];

/// The program with its commands in groups, which clap has for options only.
pub(super) fn grouped(program: Command) -> Command {
    let header = *program.get_styles().get_header();
    let literal = *program.get_styles().get_literal();
    let width = GROUPS
        .iter()
        .flat_map(|(_, names)| names.iter())
        .map(|name| name.len())
        .max();
    let width = width.unwrap_or_default();
    let mut list = String::new();
    for (heading, names) in GROUPS {
        // Writing to a string can't fail.
        let _ = writeln!(list, "{header}{heading}:{header:#}");
        for command in names.iter().filter_map(|name| program.find_subcommand(name)) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            let name = command.get_name();
            let _ = writeln!(list, "  {literal}{name:<width$}{literal:#}  {about}");
        }
        list.push('\n');
    }
    let head = "{before-help}{about-with-newline}\n{usage-heading} {usage}\n\n";
    let options = format!("{header}Options:{header:#}\n{{options}}{{after-help}}");
    program.help_template(head.to_owned() + &list + &options)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_command_is_in_one_group() {
        let program = super::super::command();
        let shown = program.get_subcommands().filter(|command| !command.is_hide_set());
        let shown: Vec<&str> = shown.map(Command::get_name).collect();
        let grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        assert_eq!(shown.iter().collect::<BTreeSet<_>>(), grouped.iter().collect());
        assert_eq!(shown.len(), grouped.len());
    }

    /// Each command has one line on a terminal of 80 columns.
    #[test]
    fn the_list_fits_a_terminal() {
        let help = super::super::command().render_help().to_string();
        for (heading, names) in GROUPS {
            assert!(help.contains(&format!("\n{heading}:\n  {} ", names[0])), "{help}");
        }
        for name in GROUPS.iter().flat_map(|(_, names)| names.iter()) {
            let line = help
                .lines()
                .find(|line| line.starts_with(&format!("  {name} ")))
                .unwrap();
            assert!(line.len() <= 80, "{line}");
        }
    }
}
