//! Man pages, one for each command.

use clap::Command;
use clap_mangen::Man;

/// The pages with their files' names, such as `oneiro-sweep-run.1`.
pub(crate) fn pages() -> Vec<(String, Vec<u8>)> {
    let mut program = super::command().disable_help_subcommand(true);
    // So that each command knows its whole name and the options of all.
    program.build();
    of(program)
}

/// The page of a command and those of its subcommands.
fn of(command: Command) -> Vec<(String, Vec<u8>)> {
    let shown = command.get_subcommands().filter(|inner| !inner.is_hide_set());
    let inner: Vec<_> = shown.cloned().flat_map(of).collect();
    let mut page = Vec::new();
    let man = Man::new(command);
    man.render(&mut page).expect("memory takes any page");
    let mut all = vec![(man.get_filename(), page)];
    all.extend(inner);
    all
}
