//! Tables of pages, their links, and the files and traits that they name.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use super::typed;

/// How many tables a page has, and the lines that are wrong: rows outside of a table, or with another number of cells than its head.
pub(crate) fn tables(page: &str) -> (usize, Vec<String>) {
    let (_, page) = typed::blocks(page);
    let (mut count, mut wrong) = (0, Vec::new());
    let mut table: Vec<(usize, &str)> = Vec::new();
    for (line, number) in page.lines().chain([""]).zip(1..) {
        if line.trim_start().starts_with('|') {
            table.push((number, line));
            continue;
        }
        if let Some(&(first, head)) = table.first() {
            count += 1;
            let is_rule = |line: &str| line.trim().chars().all(|c| "|-: ".contains(c)) && line.contains('-');
            if table.get(1).is_none_or(|(_, line)| !is_rule(line)) {
                wrong.push(format!("{first}: rows without the head of a table: {head}"));
            } else {
                let odd = table.iter().filter(|(_, row)| cells(row) != cells(head));
                wrong.extend(
                    odd.map(|(line, row)| format!("{line}: {} cells, and {} in the head", cells(row), cells(head))),
                );
            }
        }
        table.clear();
    }
    (count, wrong)
}

/// The number of a row's cells.
fn cells(row: &str) -> usize {
    let row = row.trim().replace("\\\\", "").replace("\\|", "");
    row.matches('|').count() - usize::from(row.starts_with('|')) - usize::from(row.ends_with('|')) + 1
}

/// The targets of a page's links and pictures, each with its line.
pub(crate) fn links(page: &str) -> Vec<(usize, String)> {
    let (_, page) = typed::blocks(page);
    let mut text = page.clone();
    // Code has no links.
    for (_, span) in typed::inline(&page) {
        let code = format!("`{span}`");
        let blank: String = code
            .chars()
            .map(|c| {
                if c == '\n' {
                    "\n".into()
                } else {
                    "`".repeat(c.len_utf8())
                }
            })
            .collect();
        text = text.replacen(&code, &blank, 1);
    }
    let mut found = Vec::new();
    for (at, _) in text.match_indices("](") {
        if let Some(end) = text[at..].find(')') {
            let target = &page[at + 2..at + end];
            found.push((text[..at].matches('\n').count() + 1, target.to_owned()));
        }
    }
    found
}

/// A path of the repository from a folder of it.
pub(crate) fn joined(folder: &Path, target: &str) -> PathBuf {
    let mut path = PathBuf::new();
    for part in folder.join(target).components() {
        match part {
            Component::ParentDir => {
                path.pop();
            }
            part => path.push(part),
        }
    }
    path
}

/// Whether a link of a page leads to a file, and to a heading of it. Pages are among `texts`; other files are on the disk.
pub(crate) fn resolves(texts: &BTreeMap<PathBuf, String>, page: &Path, target: &str) -> Result<(), String> {
    if ["https://", "http://", "mailto:"]
        .iter()
        .any(|scheme| target.starts_with(scheme))
    {
        return Ok(());
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = if file.is_empty() {
        page.to_owned()
    } else {
        joined(page.parent().unwrap_or(Path::new("")), file)
    };
    match texts.get(&path) {
        Some(_) if anchor.is_empty() => Ok(()),
        Some(text) if anchors(text).contains(&anchor.to_owned()) => Ok(()),
        Some(_) => Err(format!("{} has no such heading", path.display())),
        None if typed::root().join(&path).exists() && path.extension().is_none_or(|own| own != "md") => Ok(()),
        None => Err("there is no such file".into()),
    }
}

/// The anchors of a page's headings, as a web page of it has them.
fn anchors(page: &str) -> Vec<String> {
    let (_, page) = typed::blocks(page);
    let mut found: Vec<String> = Vec::new();
    for line in page.lines() {
        let named = line.split("<a id=\"").nth(1).and_then(|rest| rest.split('"').next());
        found.extend(named.map(str::to_owned));
        let heading = line.trim_start_matches('#');
        if heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        // Of a link in a heading, its text.
        let mut heading = heading.trim().to_owned();
        while let (Some(open), Some(close)) = (heading.find("]("), heading.find(')')) {
            if close < open {
                break;
            }
            heading.replace_range(open..=close, "");
            heading = heading.replacen('[', "", 1);
        }
        let anchor: String = heading
            .to_lowercase()
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect();
        let same = found.iter().filter(|own| {
            **own == anchor
                || own
                    .strip_prefix(&format!("{anchor}-"))
                    .is_some_and(|rest| rest.parse::<u32>().is_ok())
        });
        found.push(match same.count() {
            0 => anchor,
            count => format!("{anchor}-{count}"),
        });
    }
    found
}

/// Whether a file that a page names is there: a path from the root of the repository, or a source's name or the end of its path.
/// None if it isn't such a name, or stands for several.
pub(crate) fn is_there(sources: &[String], name: &str) -> Option<bool> {
    const FOLDERS: [&str; 11] = [
        "docs",
        "src",
        "host",
        "shaders",
        "tests",
        "benches",
        "python",
        "experiments",
        "examples",
        "packaging",
        "studies",
    ];
    let name = name.trim_matches(|c: char| ",;()".contains(c)).trim_end_matches('.');
    let is_for_several =
        name.contains(['*', '{', '$', '<', '@', '=']) || name.split(['/', '.', '-', '_']).any(is_capital);
    if is_for_several {
        return None;
    }
    // A place in a file.
    let name = name.split(':').next().unwrap_or_default();
    if let Some((first, _)) = name.split_once('/')
        && FOLDERS.contains(&first)
        && typed::root().join(name).exists()
    {
        return Some(true);
    }
    let path = Path::new(name);
    let is_source = path
        .extension()
        .is_some_and(|own| ["rs", "sh"].contains(&own.to_str().unwrap_or_default()));
    if is_source {
        return Some(sources.iter().any(|source| source.ends_with(&format!("/{name}"))));
    }
    let first = name.split_once('/').map(|(first, _)| first)?;
    FOLDERS.contains(&first).then_some(false)
}

/// Whether a word in capitals stands for others.
fn is_capital(word: &str) -> bool {
    word.len() > 1 && word.chars().all(|c| c.is_ascii_uppercase())
}

/// Traits that a page names, each with the file or the folder that it says it is in.
pub(crate) fn traits(page: &str) -> Vec<(String, Option<String>)> {
    let text = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut found = Vec::new();
    let mut rest = text.as_str();
    while let Some(at) = ["the trait `", "an implementation of `"]
        .iter()
        .filter_map(|words| Some(rest.find(words)? + words.len()))
        .min()
    {
        let (name, after) = rest[at..].split_once('`').unwrap_or_default();
        let place = after
            .strip_prefix(" (`")
            .and_then(|place| place.split_once('`'))
            .map(|(place, _)| place.to_owned());
        found.push((name.to_owned(), place));
        rest = after;
    }
    found
}
