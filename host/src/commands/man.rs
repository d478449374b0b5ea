//! `oneiro man`: a man page for each command.

use oneiro_base::console::{Console, counted};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;

use crate::cli;

/// Writes the pages, in place of those that an older program wrote.
pub(crate) fn run(arguments: &cli::Man, console: Console) -> Result {
    let directory = &arguments.dir;
    files::must_not_be_file(directory)?;
    plain::make_directory(directory).map_err(|error| Failure::storage(directory, &error))?;
    let pages = cli::man::pages();
    for (name, page) in &pages {
        disk::write(&directory.join(name), page)?;
    }
    console.print_plain(format!(
        "{} in {}\n",
        counted(pages.len(), "page", "pages"),
        directory.display()
    ))
}
