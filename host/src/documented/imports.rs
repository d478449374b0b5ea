//! Tests: which rooms of a crate may use which. Its manifest says which other crates it may use.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::dependencies;

/// A word, a sign or a literal with its quotation marks, and its line.
pub(super) type Token = (String, usize);

/// The words, signs and texts of a file, without comments, characters and lifetimes.
pub(super) fn tokens(text: &str) -> Vec<Token> {
    let (mut tokens, mut line) = (Vec::new(), 1);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let word = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let after = &rest[word..];
        let hashes = after.len() - after.trim_start_matches('#').len();
        let is_raw = ["r", "br", "cr"].contains(&&rest[..word]) && after[hashes..].starts_with('"');
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if is_raw {
            let end = format!("\"{}", "#".repeat(hashes));
            let begin = word + hashes + 1;
            rest[begin..].find(&end).map_or(rest.len(), |at| begin + at + end.len())
        } else if first == '"' {
            let mut is_escaped = false;
            let end = rest[1..].find(|c| {
                let ends = c == '"' && !is_escaped;
                is_escaped = c == '\\' && !is_escaped;
                ends
            });
            end.map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("'\\") {
            rest[3..].find('\'').map_or(rest.len(), |end| end + 4)
        } else if first == '\'' {
            let mut characters = rest.char_indices().skip(2);
            // Otherwise a lifetime.
            characters
                .next()
                .filter(|(_, c)| *c == '\'')
                .map_or(1, |(at, _)| at + 1)
        } else if rest.starts_with("::") {
            2
        } else {
            word.max(first.len_utf8())
        };
        let is_left_out = rest.starts_with("//") || rest.starts_with("/*") || first == '\'' || first.is_whitespace();
        if !is_left_out {
            tokens.push((rest[..length].to_owned(), line));
        }
        line += rest[..length].matches('\n').count();
        rest = &rest[length..];
    }
    tokens
}

/// The index after the bracket that closes the one at `open`.
fn closed(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (index, (token, _)) in tokens.iter().enumerate().skip(open) {
        match token.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => (),
        }
        if depth == 0 {
            return index + 1;
        }
    }
    tokens.len()
}

/// Tokens without what is only compiled for tests, and the modules that are only declared for them.
pub(super) fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    let (mut kept, mut modules, mut at) = (Vec::new(), Vec::new(), 0);
    let is = |at: usize, word: &str| tokens.get(at).is_some_and(|(token, _)| token == word);
    while at < tokens.len() {
        let mut end = at;
        while is(end, "#") && is(end + 1, "[") {
            end = closed(tokens, end + 1);
        }
        let attributes = &tokens[at..end];
        let of_tests = attributes.windows(2).any(|own| own[0].0 != "not" && own[1].0 == "test")
            && attributes.iter().any(|(token, _)| token == "cfg")
            && !attributes.iter().any(|(token, _)| token == "not");
        if !of_tests {
            end = end.max(at + 1);
            kept.extend_from_slice(&tokens[at..end]);
            at = end;
            continue;
        }
        at = end;
        while at < tokens.len() {
            if is(at, "mod") {
                modules.push(tokens[at + 1].0.clone());
            }
            let is_open = ["(", "[", "{"].iter().any(|open| is(at, open));
            let is_end = is(at, ";") || is(at, "{");
            at = if is_open { closed(tokens, at) } else { at + 1 };
            if is_end {
                break;
            }
        }
    }
    (kept, modules)
}

/// Adds the paths that begin at a token, `before` included, and returns the index after them. Only in braces are there several.
fn paths(tokens: &[Token], mut at: usize, before: &[String], found: &mut Vec<(Vec<String>, usize)>) -> usize {
    let mut path = before.to_vec();
    while let Some((token, line)) = tokens.get(at) {
        if token == "{" && !path.is_empty() {
            let end = closed(tokens, at) - 1;
            at += 1;
            while at < end {
                at = paths(tokens, at, &path, found);
                // Names before a comma may be renamed here.
                let comma = tokens[at..end].iter().position(|(token, _)| token == ",");
                at = comma.map_or(end, |comma| at + comma + 1);
            }
            return end + 1;
        }
        if token.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            path.push(token.clone());
        }
        if tokens.get(at + 1).is_none_or(|(next, _)| next != "::") {
            found.push((path, *line));
            return at + 1;
        }
        at += 2;
    }
    at
}

/// A crate's modules by their paths, with their files.
pub(super) fn modules(root: &Path, folder: &Path, found: &mut BTreeMap<Vec<String>, PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            modules(root, &path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let module = path.strip_prefix(root).unwrap().with_extension("");
            let mut module: Vec<_> = module.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
            // Beside a library, a program is another crate.
            let is_root = match module.last().unwrap().as_str() {
                "mod" | "lib" => true,
                "main" => !path.with_file_name("lib.rs").exists(),
                _ => false,
            };
            if is_root {
                module.pop();
            }
            found.insert(module, path);
        }
    }
}

/// Which rooms of a crate use which others, with the file and line of the first use. A room is a file or a folder in the crate's
/// source, or in one of `folders` there.
fn uses(root: &Path, folders: &BTreeSet<String>) -> BTreeMap<(String, String), String> {
    let mut all = BTreeMap::new();
    modules(root, root, &mut all);
    let known: BTreeSet<_> = all.keys().cloned().collect();
    let room = |module: &[String]| match module {
        [folder, room, ..] if folders.contains(folder) => format!("{folder}/{room}"),
        [room, ..] => room.clone(),
        [] => String::new(),
    };
    let (mut found, mut of_tests) = (Vec::new(), Vec::new());
    for (module, path) in &all {
        let (tokens, tests) = without_tests(&tokens(&fs::read_to_string(path).unwrap()));
        of_tests.extend(tests.into_iter().map(|name| [&module[..], &[name]].concat()));
        let mut at = 0;
        let mut own = Vec::new();
        while at < tokens.len() {
            let begins = at == 0 || tokens[at - 1].0 != "::";
            let is_path = begins && tokens.get(at + 1).is_some_and(|(next, _)| next == "::");
            at = if is_path {
                paths(&tokens, at, &[], &mut own)
            } else {
                at + 1
            };
        }
        for (path, line) in own {
            let up = path.iter().take_while(|name| *name == "super").count();
            let base = match path[0].as_str() {
                "crate" => &[][..],
                "self" => &module[..],
                "super" => &module[..module.len().saturating_sub(up)],
                child if known.contains(&[&module[..], &[child.to_owned()]].concat()) => &module[..],
                _ => continue,
            };
            let skipped = if base.len() == module.len() && path[0] != "self" {
                0
            } else {
                up.max(1)
            };
            let mut used = [base, &path[skipped..]].concat();
            while !known.contains(&used) {
                used.pop();
            }
            found.push((module.clone(), used, format!("{}:{line}", all[module].display())));
        }
    }
    let is_of_tests = |module: &[String]| of_tests.iter().any(|own| module.starts_with(own));
    let mut uses = BTreeMap::new();
    for (module, used, place) in found {
        let (from, to) = (room(&module), room(&used));
        if from != to && !from.is_empty() && !to.is_empty() && !is_of_tests(&module) && !is_of_tests(&used) {
            uses.entry((from, to)).or_insert(place);
        }
    }
    uses
}

/// Uses that are part of a circle, with their places.
fn circles(uses: &BTreeMap<(String, String), String>) -> Vec<String> {
    let reaches = |from: &String, to: &String| {
        let (mut reached, mut next) = (BTreeSet::from([from]), vec![from]);
        while let Some(room) = next.pop() {
            let more = uses
                .keys()
                .filter(|(user, used)| user == room && !reached.contains(used));
            let more: Vec<_> = more.map(|(_, used)| used).collect();
            reached.extend(&more);
            next.extend(more);
        }
        reached.contains(to)
    };
    let in_circle = uses.iter().filter(|((from, to), _)| reaches(to, from));
    in_circle
        .map(|((from, to), place)| format!("{place}: {from} uses {to}"))
        .collect()
}

pub(super) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

#[test]
fn folders_of_the_library_use_what_architecture_says() {
    let text = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let (_, section) = text.split_once("## Folders of the library").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `src/"));
    let said: BTreeMap<String, BTreeSet<String>> = rows
        .map(|row| {
            let (folder, rest) = row.split_once("` |").unwrap();
            let uses = rest.trim_end().trim_end_matches('|').rsplit('|').next().unwrap();
            let uses = uses
                .split(',')
                .map(|own| own.trim().to_owned())
                .filter(|own| !own.is_empty());
            (folder.trim_end_matches('/').to_owned(), uses.collect())
        })
        .collect();
    let folders: BTreeSet<_> = said.keys().filter(|folder| !folder.is_empty()).cloned().collect();
    let uses = uses(&root().join("src"), &folders);
    let folder = |room: &str| {
        room.split('/')
            .next()
            .filter(|own| folders.contains(*own))
            .unwrap_or("")
            .to_owned()
    };
    let mut problems = Vec::new();
    let mut found: BTreeMap<String, BTreeSet<String>> = said.keys().map(|own| (own.clone(), BTreeSet::new())).collect();
    for ((from, to), place) in &uses {
        let [from, to] = [from, to].map(|room| folder(room));
        if to.is_empty() || from == to {
            continue;
        }
        if !said[&from].contains(&to) {
            problems.push(format!("{place}: src/{from} may not use src/{to}"));
        }
        found.get_mut(&from).unwrap().insert(to);
    }
    problems.extend(circles(&uses));
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
    assert_eq!(found, said, "docs/architecture.md allows more than is used");
}

/// The folders of all crates of the program, of the kernels, and of the Python package.
pub(super) fn crates() -> Vec<PathBuf> {
    let mut crates = Vec::new();
    for folder in ["host", "shaders", "python"].map(|folder| root().join(folder)) {
        let inner = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        crates.extend(inner.chain([folder]));
    }
    crates.retain(|folder| folder.join("src").is_dir());
    crates
}

#[test]
fn rooms_of_a_crate_use_each_other_in_no_circle() {
    let circles: Vec<_> = crates()
        .iter()
        .flat_map(|folder| circles(&uses(&folder.join("src"), &BTreeSet::new())))
        .collect();
    assert!(circles.is_empty(), "\n{}", circles.join("\n"));
}

/// The first place in the Rust files of a folder where a name is `forbidden`, except in the module `except`.
fn named(source: &Path, except: &[&str], forbidden: impl Fn(&str) -> bool) -> Option<String> {
    let mut all = BTreeMap::new();
    modules(source, source, &mut all);
    let except: Vec<_> = except.iter().map(|name| (*name).to_owned()).collect();
    let mut others = all.iter().filter(|(module, _)| !module.starts_with(&except));
    others.find_map(|(_, path)| {
        let names = tokens(&fs::read_to_string(path).unwrap());
        let (name, line) = names.into_iter().find(|(name, _)| forbidden(name))?;
        Some(format!("{}:{line}: {name}", path.display()))
    })
}

#[test]
fn only_one_folder_names_wgpu() {
    let found = named(&root().join("src"), &["devices", "gpu"], |name| {
        ["wgpu", "ash"].contains(&name)
    });
    assert_eq!(found, None);
}

#[test]
fn only_the_program_prints_data() {
    let console = fs::read_to_string(root().join("host/base/src/console.rs")).unwrap();
    let console = tokens(&console);
    let functions = console.windows(2).filter(|pair| pair[0].0 == "fn");
    let prints: BTreeSet<&str> = functions
        .map(|pair| &*pair[1].0)
        .filter(|name| name.starts_with("print_"))
        .collect();
    assert!(prints.contains("print_answer"));
    let crates = fs::read_dir(root().join("host"))
        .unwrap()
        .map(|own| own.unwrap().path().join("src"));
    let found: Vec<_> = crates
        .filter(|source| source.is_dir())
        .filter_map(|source| named(&source, &["console"], |name| prints.contains(name)))
        .collect();
    assert_eq!(found, [""; 0]);
}

#[test]
fn only_the_command_line_names_clap() {
    let all = crates().into_iter().chain([root()]);
    let sources = all.filter_map(|folder| named(&folder.join("src"), &["cli"], |name| name == "clap"));
    let found: Vec<_> = sources.collect();
    assert_eq!(found, [""; 0]);
    let manifests = crates().into_iter().map(|folder| folder.join("Cargo.toml"));
    let depend: Vec<_> = manifests
        .filter(|manifest| dependencies(manifest).contains(&"clap".to_owned()))
        .collect();
    assert_eq!(depend, [root().join("host/Cargo.toml")]);
}

/// All paths of a file, those that `use` lists in braces one by one.
fn all_paths(path: &Path) -> Vec<Vec<String>> {
    let tokens = tokens(&fs::read_to_string(path).unwrap());
    let (mut found, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        at = if tokens.get(at + 1).is_some_and(|(next, _)| next == "::") {
            paths(&tokens, at, &[], &mut found)
        } else {
            at + 1
        };
    }
    found.into_iter().map(|(path, _)| path).collect()
}

/// The modules of a file that are public, except for those of tests.
fn public_modules(path: &Path) -> Vec<String> {
    let (tokens, _) = without_tests(&tokens(&fs::read_to_string(path).unwrap()));
    let is_public = tokens.windows(3).filter(|own| own[0].0 == "pub" && own[1].0 == "mod");
    is_public.map(|own| own[2].0.clone()).collect()
}

/// What a private module has and nobody uses, the compiler finds.
#[test]
fn a_public_module_is_used_by_another_package() {
    let (host, all) = (root().join("host"), crates());
    let libraries: Vec<&str> = all
        .iter()
        .filter_map(|folder| folder.strip_prefix(&host).ok()?.to_str())
        .filter(|name| !name.is_empty())
        .collect();
    let sources = ["benches", "examples", "host/benches", "host/src", "python/src", "tests"].map(str::to_owned);
    let sources = sources
        .into_iter()
        .chain(libraries.iter().map(|name| format!("host/{name}/src")));
    let packages: BTreeMap<_, _> = sources
        .map(|folder| {
            let mut files = BTreeMap::new();
            let source = root().join(&folder);
            if source.is_dir() {
                modules(&source, &source, &mut files);
            }
            let paths: Vec<_> = files.values().flat_map(|path| all_paths(path)).collect();
            (folder, (files, paths))
        })
        .collect();
    let mut unused = Vec::new();
    for library in &libraries {
        let folder = format!("host/{library}/src");
        let others: Vec<_> = packages
            .iter()
            .filter(|(other, _)| **other != folder)
            .flat_map(|(_, (_, paths))| paths)
            .collect();
        for (module, file) in &packages[&folder].0 {
            for name in public_modules(file) {
                // Whole, or after the name of its parent, which an import gives.
                let whole = [&[format!("oneiro_{library}")][..], module, &[name]].concat();
                let short = &whole[whole.len() - 2..];
                let is_used = |path: &&Vec<String>| path.starts_with(&whole) || path.windows(2).any(|own| own == short);
                if !others.iter().any(is_used) {
                    unused.push(whole.join("::"));
                }
            }
        }
    }
    assert_eq!(unused, [""; 0], "public, and used by no other package");
}
