//! `oneiro import`: an experiment from a file of another simulator, or from a map.

use std::path::{Path, PathBuf};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_base::progress::meanwhile;
use oneiro_lab::import::{self, Options};
use serde_json::json;

use crate::cli::Import;

/// Writes the experiment, and lists what it does not have.
pub(crate) fn run(arguments: &Import, console: Console) -> Result {
    let out = arguments.out.clone().unwrap_or_else(|| beside(&arguments.file));
    files::must_end_in("--out", &out, "toml", "the experiment is a TOML file")?;
    let options = Options {
        maze: arguments.maze.clone(),
        mm_per_pixel: arguments.mm_per_pixel,
        tolerance: arguments.tolerance,
        threshold: arguments.threshold,
    };
    let imported = meanwhile("reading the file", console.bars(), || {
        import::import(&arguments.file, &options, &out)
    })?;
    files::write_new(&out, imported.text.as_bytes())?;
    let path = out.display().to_string();
    let mut value = imported.lists();
    value["experiment"] = json!(path);
    value["file"] = json!(arguments.file.display().to_string());
    value["format"] = json!(imported.format);
    let answer = Answer {
        messages: vec![format!(
            "wrote {path}: {} taken from {}, {} not taken",
            counted(imported.taken() as u64, "thing", "things"),
            imported.format,
            imported.left_out()
        )],
        ..Answer::new(imported.not_taken(), value)
    };
    console.print_answer(&answer)?;
    console.next(format!("oneiro check {}", files::for_shell(&path)));
    Ok(())
}

/// The experiment's name in the current folder.
fn beside(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let name: String = stem.chars().map(|c| if is_plain(c) { c } else { '-' }).collect();
    let name = name.trim_start_matches('-');
    PathBuf::from(if name.is_empty() { "imported" } else { name }).with_extension("toml")
}
