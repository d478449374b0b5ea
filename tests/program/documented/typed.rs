//! Finds the commands that documents, experiments, help texts and messages tell a user to type.

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the repository.
pub(crate) fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.canonicalize().expect("the repository")
}

/// All files of the repository with one of these extensions, relative to its root, in order; without what is built.
pub(crate) fn files(extensions: &[&str]) -> Vec<PathBuf> {
    let root = root();
    let mut found = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)
            .expect("a folder")
            .map(|entry| entry.expect("an entry"))
        {
            let (path, name) = (entry.path(), entry.file_name());
            let name = name.to_string_lossy();
            let is_left_out = name.starts_with('.') || ["target", "shared", "__pycache__"].contains(&&*name);
            if is_left_out {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if extensions
                .iter()
                .any(|extension| path.extension().is_some_and(|own| own == *extension))
            {
                found.push(path.strip_prefix(&root).expect("a path below it").to_owned());
            }
        }
    }
    found.sort();
    found
}

/// The text of a file of the repository.
pub(crate) fn text(path: &Path) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The code within the sentences of each page, and its place. The changelog speaks of what was.
pub(crate) fn spans() -> Vec<(String, String)> {
    let pages = files(&["md"])
        .into_iter()
        .filter(|path| !path.ends_with("CHANGELOG.md"));
    pages
        .flat_map(|path| {
            let (_, rest) = blocks(&text(&path));
            let spans = inline(&rest).into_iter();
            let placed = spans.map(|(line, span)| (format!("{}:{line}", path.display()), span.to_owned()));
            placed.collect::<Vec<_>>()
        })
        .collect()
}

/// A fenced block of a page.
pub(crate) struct Block {
    /// The line of its first fence, from 1.
    pub(crate) line: usize,
    /// Its language, and the words after it.
    pub(crate) info: Vec<String>,
    pub(crate) text: String,
}

impl Block {
    pub(crate) fn language(&self) -> &str {
        self.info.first().map_or("", String::as_str)
    }

    /// What it types into a shell; of a console's record, the lines after prompts.
    pub(crate) fn script(&self) -> Option<String> {
        match self.language() {
            "sh" => Some(self.text.clone()),
            "console" => Some(
                self.text
                    .lines()
                    .filter_map(|line| line.strip_prefix("$ "))
                    .map(|line| line.to_owned() + "\n")
                    .collect(),
            ),
            _ => None,
        }
    }
}

/// The fenced blocks of a page, and the page with empty lines in their place.
pub(crate) fn blocks(page: &str) -> (Vec<Block>, String) {
    let (mut blocks, mut rest) = (Vec::new(), String::new());
    let mut open: Option<Block> = None;
    for (line, number) in page.lines().zip(1..) {
        match (&mut open, line.trim_start().strip_prefix("```")) {
            (None, Some(info)) => {
                open = Some(Block {
                    line: number,
                    info: info.split_whitespace().map(str::to_owned).collect(),
                    text: String::new(),
                });
            }
            (None, None) => rest += line,
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(block), None) => block.text += &(line.to_owned() + "\n"),
        }
        rest += "\n";
    }
    assert!(open.is_none(), "a block has no end");
    (blocks, rest)
}

/// The code within a page's lines, which has no fenced blocks any more, each with its line.
pub(crate) fn inline(page: &str) -> Vec<(usize, &str)> {
    // A span may go on in the next line of its paragraph.
    let mut found = Vec::new();
    let mut from = 0;
    for paragraph in page.split_inclusive("\n\n") {
        let mut at = from;
        for (index, piece) in paragraph.split('`').enumerate() {
            if index % 2 == 1 {
                found.push((page[..at].matches('\n').count() + 1, piece));
            }
            at += piece.len() + 1;
        }
        from += paragraph.len();
    }
    found
}

/// The commands of a shell's script as words: without what only a shell sees, and with 1 for its variables.
pub(crate) fn commands(script: &str) -> Vec<Vec<String>> {
    fn end(word: &mut Option<String>, commands: &mut [Vec<String>]) {
        if let (Some(word), Some(command)) = (word.take(), commands.last_mut()) {
            command.push(word);
        }
    }
    let mut commands = vec![Vec::new()];
    let mut word: Option<String> = None;
    let mut characters = script.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '\\' if characters.peek() == Some(&'\n') => {
                characters.next();
                end(&mut word, &mut commands);
            }
            '\'' => {
                let quoted: String = characters.by_ref().take_while(|c| *c != '\'').collect();
                word.get_or_insert_default().push_str(&quoted);
            }
            '"' => {
                let quoted: String = characters.by_ref().take_while(|c| *c != '"').collect();
                let mut parts = quoted.split('$');
                let word = word.get_or_insert_default();
                word.push_str(parts.next().unwrap_or_default());
                for part in parts {
                    word.push('1');
                    word.push_str(part.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_'));
                }
            }
            '$' => {
                if characters.peek() == Some(&'(') {
                    characters.by_ref().take_while(|c| *c != ')').for_each(drop);
                } else {
                    while characters.next_if(|c| c.is_ascii_alphanumeric() || *c == '_').is_some() {}
                }
                word.get_or_insert_default().push('1');
            }
            '#' if word.is_none() => characters.by_ref().take_while(|c| *c != '\n').for_each(|_| ()),
            ' ' => end(&mut word, &mut commands),
            '\n' | ';' | '|' | '&' => {
                end(&mut word, &mut commands);
                commands.push(Vec::new());
            }
            other => word.get_or_insert_default().push(other),
        }
        // The line's end after a comment.
        if character == '#' && word.is_none() {
            commands.push(Vec::new());
        }
    }
    end(&mut word, &mut commands);
    commands.retain(|command| !command.is_empty());
    commands
}

/// The commands of a script that start the program, wherever it is, each from the word `oneiro` on.
pub(crate) fn of_program(script: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for mut words in commands(script) {
        // Whatever runs a command on another computer, or times it.
        let is_before =
            |word: &String| ["time", "do", "until", "while", "if", "!"].contains(&word.as_str()) || word.contains('=');
        while words.first().is_some_and(is_before) {
            words.remove(0);
        }
        if words.first().is_some_and(|word| word == "ssh") {
            words.retain(|word| word != "-t");
            words.drain(..2);
        }
        // As `bash -c` has them.
        for word in words
            .iter()
            .filter(|word| word.contains("oneiro ") && word.contains(' '))
        {
            found.extend(of_program(word));
        }
        let cargo = ["cargo", "run", "--release", "--"];
        if words.len() > cargo.len() && words.iter().zip(cargo).all(|(word, own)| word == own) {
            words.splice(..cargo.len(), ["oneiro".to_owned()]);
        }
        if words.first().is_some_and(|word| word == "oneiro" || word == "./oneiro") {
            // Where its output goes.
            if let Some(at) = words.iter().position(|word| word.starts_with('>')) {
                words.truncate(at);
            }
            "oneiro".clone_into(&mut words[0]);
            found.push(words);
        }
    }
    found
}
