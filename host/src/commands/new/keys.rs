//! `oneiro new --keys`: lists the settings of an experiment.

use oneiro::parameter::nearest;
use oneiro_base::answer::Answer;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::experiment::reference::{self, Entry};
use serde_json::json;

/// The keys that contain a text.
///
/// # Errors
/// Exit 3: there is none.
pub(super) fn list(part: &str) -> Result<Answer> {
    let of = |mut entries: Vec<Entry>| {
        entries.retain(|entry| entry.key.contains(part));
        entries
    };
    let (single, swarm) = (of(reference::single()), of(reference::swarm()));
    if single.is_empty() && swarm.is_empty() {
        let (single, swarm) = (reference::single(), reference::swarm());
        let keys = single.iter().chain(&swarm).map(|entry| entry.key);
        let words = keys.flat_map(|key| key.split(['.', '_', '[']).chain(std::iter::once(key)));
        return Err(Failure::input(format_args!(
            "no key contains `{part}`{}",
            nearest(words, part).map_or_else(
                || "; allowed: a part of a key, such as noise".to_owned(),
                |word| format!("; did you mean {word}?")
            )
        )));
    }
    let mut text = String::new();
    for (title, entries) in [
        ("Experiments with single robots", &single),
        ("Experiments with swarms", &swarm),
    ] {
        if !entries.is_empty() {
            text.extend([title, "\n"]);
        }
        for entry in entries {
            let default = entry
                .default
                .as_ref()
                .map_or_else(String::new, |default| format!(" = {default}"));
            text.extend(["  ", entry.key, &default, "\n      ", &entry.words(), "\n"]);
        }
    }
    Ok(Answer::new(
        text.trim_end(),
        json!({ "single": single, "swarm": swarm }),
    ))
}
