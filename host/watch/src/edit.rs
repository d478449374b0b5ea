//! `oneiro watch --edit`: the page has a form with an experiment's main values, and a button that evolves with them. It starts ordinary
//! runs, one at a time, with a directory each.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::program;
use oneiro_lab::experiment::{GREATEST_SEED, reference};
use oneiro_lab::record::SavedRun;
use oneiro_lab::runs;
use serde::Deserialize;
use serde_json::{Value as Json, json};

/// Keys that the form has in any case, where the experiment has them.
const MAIN: [&str; 7] = [
    "cycles",
    "trials",
    "noise.sensor",
    "noise.motor",
    "evolution.generations",
    "evolution.population",
    "evolution.parents",
];
/// Bytes of a value.
const LONGEST: usize = 200;
/// How long a run is waited for that may refuse its values.
const REFUSAL: Duration = Duration::from_secs(3);
/// Bytes of a message that are shown.
const SHOWN: u64 = 4096;

/// An experiment that the page may change and run.
pub(crate) struct Editor {
    experiment: PathBuf,
    /// Who may do that: 32 hexadecimal digits.
    pub(crate) secret: String,
    running: Mutex<Option<Child>>,
}

/// What the page asks for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wish {
    seed: String,
    /// Keys with their values as TOML.
    set: Vec<(String, String)>,
}

/// A value of the form.
struct Field {
    key: &'static str,
    value: String,
    unit: &'static str,
    about: String,
}

impl Editor {
    /// The experiment is read whenever it is needed: it may change in an editor.
    ///
    /// # Errors
    /// Exit 3 if it can't be read.
    pub(crate) fn new(experiment: &Path, secret: String) -> Result<Self> {
        let own = Self {
            experiment: experiment.to_owned(),
            secret,
            running: Mutex::new(None),
        };
        own.fields()?;
        Ok(own)
    }

    /// The form: values that the experiment's file has, and the main ones.
    fn fields(&self) -> Result<Vec<Field>> {
        let experiment = runs::read(&self.experiment, &[])?;
        let is_table = |error| Failure::input(format_args!("{}: {error}", self.experiment.display()));
        let resolved: toml::Table = experiment.resolved_toml(1).parse().map_err(is_table)?;
        let file: toml::Table = files::text(&self.experiment)?.parse().map_err(is_table)?;
        let entries = if experiment.swarm().is_some() {
            reference::swarm()
        } else {
            reference::single()
        };
        let field = |entry: reference::Entry| {
            let is_shown = MAIN.contains(&entry.key) || found(&file, entry.key).is_some();
            let value = found(&resolved, entry.key).filter(|value| is_shown && is_simple(value))?;
            let is_named = ["name", "seed", "files"].contains(&entry.key);
            (!is_named).then(|| Field {
                key: entry.key,
                value: value.to_string(),
                unit: entry.unit,
                about: entry.words(),
            })
        };
        Ok(entries.into_iter().filter_map(field).collect())
    }

    /// The form as JSON.
    pub(crate) fn form(&self) -> Json {
        let field = |own: &Field| json!({ "key": own.key, "value": own.value, "unit": own.unit, "about": own.about });
        match self.fields() {
            Ok(fields) => json!({ "fields": fields.iter().map(field).collect::<Vec<_>>() }),
            Err(failure) => json!({ "problem": failure.to_string() }),
        }
    }

    /// A run's values of the form's keys, and its seed.
    pub(crate) fn values(&self, run: &SavedRun) -> Json {
        let resolved: toml::Table = run.experiment().resolved_toml(run.seed()).parse().unwrap_or_default();
        let value = |field: &Field| Some((field.key.to_owned(), found(&resolved, field.key)?.to_string().into()));
        let mut values: serde_json::Map<String, Json> = self.fields().iter().flatten().filter_map(value).collect();
        values.insert("seed".to_owned(), run.seed().to_string().into());
        values.into()
    }

    /// Starts a run with these values.
    ///
    /// # Errors
    /// What is wrong with them, or that the last run still evolves.
    pub(crate) fn evolve(&self, body: &[u8]) -> std::result::Result<(), String> {
        let wish: Wish = serde_json::from_slice(body).map_err(|error| error.to_string())?;
        let seed = wish.seed.parse::<u64>().ok().filter(|seed| *seed <= GREATEST_SEED);
        let Some(seed) = seed else {
            return Err(format!(
                "seed: is {}; allowed: a whole number, 0 to {GREATEST_SEED}",
                wish.seed
            ));
        };
        let fields = self.fields().map_err(|failure| failure.to_string())?;
        let mut settings = Vec::new();
        for (key, value) in wish.set {
            let Some(field) = fields.iter().find(|field| field.key == key) else {
                return Err(format!("{key}: is no key of the form"));
            };
            if value.len() > LONGEST || value.chars().any(char::is_control) {
                return Err(format!("{key}: is too long, or has several lines"));
            }
            if value != field.value {
                settings.push(format!("--set={key}={value}"));
            }
        }
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        if running.as_mut().is_some_and(is_running) {
            return Err("the last run still evolves: wait for its end, or stop it".to_owned());
        }
        let broken = |error: std::io::Error| format!("a run can't be started: {error}");
        let mut child = Command::new(program::path().map_err(broken)?)
            .args(["run", "--quiet", &format!("--seed={seed}")])
            .args(&settings)
            .arg("--")
            .arg(&self.experiment)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(broken)?;
        let begun = Instant::now();
        let messages = child.stderr.take();
        while begun.elapsed() < REFUSAL {
            match child.try_wait().map_err(broken)? {
                None => thread::sleep(Duration::from_millis(50)),
                Some(status) if status.success() => break,
                Some(_) => {
                    let mut text = String::new();
                    let read = messages.map(|messages| messages.take(SHOWN).read_to_string(&mut text));
                    let _ = read.transpose().map_err(broken)?;
                    return Err(of_form(text.trim(), &settings));
                }
            }
        }
        // Nobody reads further messages, and nothing waits for that.
        if let Some(mut messages) = messages {
            thread::spawn(move || std::io::copy(&mut messages, &mut std::io::sink()));
        }
        *running = Some(child);
        Ok(())
    }

    /// Stops the run, which can be continued.
    pub(crate) fn stop(&self) {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(child) = running.as_mut()
            && is_running(child)
        {
            #[cfg(unix)]
            if let Some(process) = rustix::process::Pid::from_raw(child.id().cast_signed()) {
                let _ = rustix::process::kill_process(process, rustix::process::Signal::TERM);
            }
            #[cfg(not(unix))]
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        self.stop();
    }
}

/// A message of the program without the options that the form's values became.
fn of_form(message: &str, settings: &[String]) -> String {
    let mut rest = message.strip_prefix("oneiro: ").unwrap_or(message);
    for setting in settings {
        let option = format!("{}: ", setting.replacen('=', " ", 1));
        rest = rest.strip_prefix(&*option).unwrap_or(rest);
    }
    rest.to_owned()
}

fn is_running(child: &mut Child) -> bool {
    matches!(child.try_wait(), Ok(None))
}

/// A value of a table by its dotted key.
fn found<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    match key.split_once('.') {
        Some((first, rest)) => found(table.get(first)?.as_table()?, rest),
        None => table.get(key),
    }
}

/// Whether a value fits a line: a number, a word, or some of these.
fn is_simple(value: &toml::Value) -> bool {
    match value {
        toml::Value::Table(_) | toml::Value::Datetime(_) => false,
        toml::Value::Array(all) => all.len() <= 8 && all.iter().all(|own| !own.is_table() && !own.is_array()),
        _ => true,
    }
}
