//! What tutorials and the README show under a block: its output, as a user sees it who has no progress bar.

use super::typed::{self, Block};

/// Whether a page shows what its commands print. Nothing is shortened there.
pub(crate) fn shows(page: &str) -> bool {
    page == "README.md" || page.starts_with("docs/tutorials/")
}

/// For each block of a page, the block of text that shows its output: the next one, if only empty lines are between them.
pub(crate) fn of(page: &str, blocks: &[Block], index: usize) -> Option<usize> {
    let (block, next) = (&blocks[index], blocks.get(index + 1)?);
    let end = block.line + block.text.lines().count() + 1;
    let is_next = page
        .lines()
        .skip(end)
        .take(next.line - 1 - end)
        .all(|line| line.trim().is_empty());
    (is_next && next.language() == "text").then_some(index + 1)
}

/// A page with the output of its blocks, each with its index, wherever the output differs in more than what [`masked`] hides.
pub(crate) fn renewed(page: &str, printed: &[(usize, String)]) -> String {
    let (blocks, _) = typed::blocks(page);
    let mut lines: Vec<&str> = page.lines().collect();
    for (index, output) in printed.iter().rev() {
        let block = &blocks[*index];
        if masked(output) != masked(&block.text) {
            let last = block.line + block.text.lines().count();
            lines.splice(block.line..last, output.lines().map(str::trim_end));
        }
    }
    lines.join("\n") + "\n"
}

/// An output without what differs between machines and moments, as `docs/testing.md` says: the name of the device, the number
/// before a unit of time or speed, dates, files that only some builds write, and how far apart words are.
pub(crate) fn masked(output: &str) -> String {
    const UNITS: [&str; 7] = ["ms", "s", "min", "h", "steps/s", "robot-steps/s", "episodes/s"];
    const SCALES: [&str; 4] = ["k", "M", "G", "million"];
    let is_number = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_digit() || c == '.') && word.contains(|c| c != '.')
    };
    let is_date = |word: &str| {
        let shape: String = word.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect();
        shape.starts_with("0000-00-00") || shape.starts_with("00:00")
    };
    let line = |line: &str| {
        let device = line.find(" on cpu (").map(|at| &line[at + 4..]);
        let line = device.map_or(line.to_owned(), |device| line.replace(device, "DEVICE"));
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_unit = |index: usize| {
            words
                .get(index)
                .is_some_and(|word| UNITS.contains(&word.trim_end_matches([',', '.', ';', ':', ')'])))
        };
        let word = |(index, word): (usize, &&str)| {
            let is_scaled = words.get(index + 1).is_some_and(|next| SCALES.contains(next)) && is_unit(index + 2);
            match *word {
                word if is_number(word.trim_start_matches('(')) && (is_unit(index + 1) || is_scaled) => "N",
                word if SCALES.contains(&word) && is_unit(index + 1) => "",
                _ if is_unit(index) => "UNIT",
                word if is_date(word) => "DATE",
                word => word,
            }
            .to_owned()
        };
        let words: Vec<String> = words.iter().enumerate().map(word).collect();
        words
            .into_iter()
            .filter(|word| !word.is_empty())
            .collect::<Vec<_>>()
            .join(" ")
    };
    let lines = output.lines().filter(|line| !line.ends_with(".parquet")).map(line);
    lines.collect::<Vec<_>>().join("\n").trim().to_owned()
}
