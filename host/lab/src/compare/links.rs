//! Links from a comparison's page to the directories and pages of its runs.

use std::path::{Component, Path};

use oneiro_report::page::breakable;

use super::sources::Run;
use crate::sweep::report::PAGE;

/// Pages of a run's directory, if they exist.
const PAGES: [&str; 3] = ["report.html", "replay.html", "archive.html"];

/// A run's source, as HTML, with links from a page in `out`: to its directory and its pages, or to its row in its sweep's report.
pub(super) fn html(out: &Path, run: &Run) -> String {
    let words = breakable(&run.source);
    let (directory, number) = &run.place;
    let Some(link) = relative(out, directory) else {
        return words;
    };
    if let Some(number) = number {
        return if directory.join(PAGE).is_file() {
            format!("<a href=\"{link}/{PAGE}#run-{number}\">{words}</a>")
        } else {
            format!("<a href=\"{link}/\">{words}</a>")
        };
    }
    let pages = PAGES.iter().filter(|page| directory.join(page).is_file());
    let pages = pages.map(|page| format!(", <a href=\"{link}/{page}\">{page}</a>"));
    format!("<a href=\"{link}/\">{words}</a>{}", pages.collect::<String>())
}

/// The path from one directory to another, as a link; none if there is none.
fn relative(from: &Path, to: &Path) -> Option<String> {
    let (from, to) = (from.canonicalize().ok()?, to.canonicalize().ok()?);
    let common = from
        .components()
        .zip(to.components())
        .take_while(|(a, b)| a == b)
        .count();
    // On other drives there is no way.
    if common == 0 {
        return None;
    }
    let up = from.components().skip(common).map(|_| "..".to_owned());
    let down = to.components().skip(common).map(|part| match part {
        Component::Normal(name) => quoted(&name.to_string_lossy()),
        _ => String::new(),
    });
    let all: Vec<String> = up.chain(down).collect();
    Some(if all.is_empty() { ".".to_owned() } else { all.join("/") })
}

/// A file's name in a link.
fn quoted(name: &str) -> String {
    name.bytes()
        .map(|byte| match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(byte).to_string(),
            _ => format!("%{byte:02X}"),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_from_the_page_to_the_run() {
        let folder = std::env::temp_dir().join(format!("oneiro-links-{}", std::process::id()));
        let [out, run] = ["out/compare", "runs/a b#1"].map(|name| folder.join(name));
        for own in [&out, &run] {
            std::fs::create_dir_all(own).unwrap();
        }
        assert_eq!(relative(&out, &run).as_deref(), Some("../../runs/a%20b%231"));
        assert_eq!(relative(&out, &out).as_deref(), Some("."));
        assert_eq!(relative(&out, &folder.join("none")), None);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
