//! Parts of all finished runs' pages: settings, and commands to type next.

use oneiro_base::contents::Entry;
use oneiro_report::figures::escaped;
use oneiro_report::page::{Cell, Head, Row, paragraph, table};

use crate::experiment::Difference;

/// The page.
pub(crate) const FILE: &str = "report.html";

/// Number of letters shown of a setting's value.
const LETTERS: usize = 80;
/// Puts the run's path into the commands of a page that is opened as a file.
const PATHS: &str = "<script>\n\
    if (location.protocol === 'file:') {\n\
    \x20 const folder = decodeURIComponent(location.pathname).replace(/\\/[^/]*$/, '').replace(/^\\/([A-Z]:)/, '$1');\n\
    \x20 const typed = /^[\\w./:@%+-]+$/.test(folder) ? folder : `'${folder.replaceAll(\"'\", \"'\\\\''\")}'`;\n\
    \x20 for (const own of document.querySelectorAll('[data-run]')) own.textContent = typed;\n\
    \x20 document.getElementById('here').hidden = true;\n\
    }\n</script>\n";

/// Its description in a run's directory.
pub(super) fn entry() -> Entry {
    let about = "a page about the run: what came out, pictures, settings that differ from the defaults, and commands to type next";
    Entry::file(FILE, about)
}

/// A table of the settings that differ from their defaults.
pub(super) fn settings(all: &[Difference]) -> String {
    if all.is_empty() {
        return paragraph("All settings have their defaults.");
    }
    let clipped = |value: &str| match value.char_indices().nth(LETTERS) {
        Some((end, _)) => format!("{} \u{2026}", &value[..end]),
        None => value.to_owned(),
    };
    let rows: Vec<Row> = all
        .iter()
        .map(|own| {
            let [usual, here] = own.values.each_ref().map(|value| clipped(value));
            vec![Cell::name(&own.key), Cell::code(&here), Cell::code(&usual)].into()
        })
        .collect();
    let head = ["setting", "here", "default"].map(Head::Text);
    let words = "Settings that differ from their defaults; config.toml has all.";
    table("", words, &head, &rows)
}

/// A table of commands, in which `RUN` is the run's path, and what they are for.
pub(super) fn commands(all: &[(&str, String)]) -> String {
    let row = |(command, about): &(&str, String)| -> Row {
        let words = command.split(' ').map(|word| match word {
            "RUN" => "<span data-run=\"\">.</span>".to_owned(),
            word => escaped(word),
        });
        let command = words.collect::<Vec<_>>().join(" ");
        vec![Cell::html(format!("<code>oneiro {command}</code>")), Cell::text(about)].into()
    };
    let rows: Vec<Row> = all.iter().map(row).collect();
    let here = "<p id=\"here\">To be typed in this run\u{2019}s directory.</p>\n";
    here.to_owned() + &table("", "", &[Head::Text("command"), Head::Text("what for")], &rows) + PATHS
}
