//! The scripts of pages: ES modules in `components/`, joined into one script that needs no other file.

/// Modules by name.
macro_rules! modules {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("components/", $name, ".js")))),*]
    };
}

/// All modules.
const MODULES: &[(&str, &str)] = modules!(
    "arena" "chart" "colours" "contents" "diagram" "dom" "elites" "episode" "facts" "foragers" "messages" "player" "readings" "record" "report"
    "robots" "saving" "scrolling" "sensors" "stage" "svg-chart" "svg-pen" "table" "tiles" "trails" "watch"
);

/// Makes one script of a page's module, such as `report`, and of all that it imports: without imports, exports and comments, in the order in
/// which they need each other.
pub fn bundle(page: &str) -> String {
    let mut script = String::new();
    for (_, text) in needed(page) {
        let mut in_comment = false;
        for line in text.lines() {
            let trimmed = line.trim_start();
            in_comment |= trimmed.starts_with("/**");
            let is_left_out = in_comment || trimmed.is_empty() || trimmed.starts_with("//") || imported(line).is_some();
            if !is_left_out {
                script.push_str(line.strip_prefix("export ").unwrap_or(line));
                script.push('\n');
            }
            in_comment &= !trimmed.ends_with("*/");
        }
    }
    script
}

/// The module of a name after all that it imports, with their texts.
fn needed(name: &str) -> Vec<(&'static str, &'static str)> {
    fn visit(name: &str, found: &mut Vec<(&'static str, &'static str)>) {
        if found.iter().any(|(other, _)| *other == name) {
            return;
        }
        if let Some((name, text)) = MODULES.iter().find(|(other, _)| *other == name) {
            text.lines().filter_map(imported).for_each(|other| visit(other, found));
            found.push((name, text));
        }
    }
    let mut found = Vec::new();
    visit(name, &mut found);
    found
}

/// The name of the module that a line imports.
fn imported(line: &str) -> Option<&str> {
    line.strip_prefix("import ")?
        .rsplit_once("'./")?
        .1
        .strip_suffix(".js';")
}

/// The keys that `facts.js` gives records of these types, sorted.
#[cfg(test)]
pub(crate) fn typed_keys(types: &[&str]) -> Vec<String> {
    let (_, facts) = MODULES.iter().find(|(name, _)| *name == "facts").unwrap();
    let of_type = |name: &&str| {
        let (_, after) = facts.split_once(&format!("@typedef {{object}} {name}\n")).unwrap();
        after.split("*/").next().unwrap().split("@property {").skip(1)
    };
    let key = |property: &str| {
        let mut depth = 1;
        let end = property.find(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0
        });
        let key = property[end.unwrap() + 2..].split_whitespace().next().unwrap();
        key.trim_matches(['[', ']']).to_owned()
    };
    let mut keys: Vec<String> = types.iter().flat_map(of_type).map(key).collect();
    keys.sort();
    keys
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;
    use std::process::Command;
    use std::{env, fs};

    use super::*;
    use crate::skips::skipped;

    const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/components");
    const PAGES: [&str; 5] = ["elites", "episode", "foragers", "report", "watch"];

    /// What a module declares at its top level, and whether it exports it.
    fn declared(text: &str) -> impl Iterator<Item = (&str, bool)> {
        let declarations = text.lines().filter_map(|line| {
            let (line, is_exported) = line.strip_prefix("export ").map_or((line, false), |line| (line, true));
            let (kind, rest) = line.split_once(' ')?;
            let names = match kind {
                "const" | "let" => rest.split_once(" = ").map_or(rest, |(names, _)| names),
                "class" | "function" => rest,
                _ => return None,
            };
            Some((names, is_exported))
        });
        declarations.flat_map(|(names, is_exported)| {
            let pattern = names.trim_matches(['{', '}', '[', ']', ' ']);
            let several = pattern.len() < names.len() && names.starts_with(['{', '[']);
            let names = pattern.split(',').take(if several { usize::MAX } else { 1 });
            // Of `key: name`, the name.
            names.map(move |part| {
                let part = part.rsplit(": ").next().unwrap_or(part).trim();
                let end = part
                    .find(|c: char| !c.is_alphanumeric() && c != '_')
                    .unwrap_or(part.len());
                (&part[..end], is_exported)
            })
        })
    }

    #[test]
    fn all_modules_are_known_and_needed() {
        let files = fs::read_dir(FOLDER)
            .unwrap()
            .map(|file| file.unwrap().file_name().into_string().unwrap());
        let files: BTreeSet<String> = files
            .filter_map(|name| name.strip_suffix(".js").map(str::to_owned))
            .collect();
        assert_eq!(files, MODULES.iter().map(|(name, _)| (*name).to_owned()).collect());
        let used = PAGES.into_iter().flat_map(needed).map(|(name, _)| name.to_owned());
        assert_eq!(files, used.collect());
    }

    #[test]
    fn imports_are_exported_by_earlier_modules() {
        for page in PAGES {
            let modules = needed(page);
            for (place, (name, text)) in modules.iter().enumerate() {
                for line in text.lines().filter(|line| line.starts_with("import ")) {
                    let from = imported(line).unwrap_or_else(|| panic!("{name}: {line}"));
                    let (_, exporting) = modules[..place].iter().find(|(other, _)| *other == from).expect(line);
                    let names = line
                        .split_once('{')
                        .and_then(|(_, rest)| rest.split_once('}'))
                        .expect(line)
                        .0;
                    for name in names.split(',').map(str::trim) {
                        assert!(declared(exporting).any(|own| own == (name, true)), "{line}");
                    }
                }
            }
        }
    }

    /// Modules share the bundle's names.
    #[test]
    fn no_two_modules_declare_a_name() {
        for page in PAGES {
            let mut names = BTreeSet::new();
            for (module, text) in needed(page) {
                for (name, _) in declared(text) {
                    assert!(names.insert(name), "{page}: {module} declares {name} again");
                }
            }
        }
    }

    #[test]
    fn a_bundle_is_code_only() {
        for page in PAGES {
            let script = bundle(page);
            assert!(script.lines().all(|line| line.chars().count() <= 140));
            let is_code = |line: &str| {
                !["import ", "export ", "//", "/**", "*"]
                    .iter()
                    .any(|left_out| line.starts_with(left_out))
            };
            assert_eq!(
                script.lines().map(str::trim).find(|line| !is_code(line)),
                None,
                "{page}"
            );
        }
    }

    /// The TypeScript compiler finds nothing in the modules, whose types are in comments.
    #[test]
    fn types_are_right() {
        let folders: Vec<_> = env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect();
        let Some(compiler) = folders
            .iter()
            .map(|folder| folder.join("tsc"))
            .find(|path| path.is_file())
        else {
            skipped("tsc", "the types of pages' scripts: there is no TypeScript compiler");
            return;
        };
        let checked = Command::new(compiler)
            .args(["--noEmit", "--allowJs", "--checkJs", "--strict", "--noUnusedLocals"])
            .args([
                "--target",
                "es2021",
                "--module",
                "es2020",
                "--lib",
                "es2021,dom,dom.iterable",
            ])
            .args(PAGES.map(|page| Path::new(FOLDER).join(format!("{page}.js"))))
            .output()
            .unwrap();
        assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
    }
}
