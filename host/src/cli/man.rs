//! Man pages, one for each command.

use clap::Command;
use clap_mangen::Man;

/// The pages with their files' names, such as `oneiro-sweep-run.1`.
pub(crate) fn pages() -> Vec<(String, Vec<u8>)> {
    of(super::command(), "")
}

/// The page of a command and those of its subcommands; `before` is what its name begins with.
fn of(command: Command, before: &str) -> Vec<(String, Vec<u8>)> {
    let name = format!("{before}{}", command.get_name());
    let shown = command.get_subcommands().filter(|inner| !inner.is_hide_set());
    let inner: Vec<_> = shown.flat_map(|inner| of(inner.clone(), &format!("{name}-"))).collect();
    let mut page = Vec::new();
    let man = Man::new(command.name(name.clone()));
    man.render(&mut page).expect("memory takes any page");
    let mut all = vec![(format!("{name}.1"), page)];
    all.extend(inner);
    all
}
