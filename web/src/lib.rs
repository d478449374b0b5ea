//! Evolution in a browser: a run that a page, or a worker of it, advances step by step. `build.sh` makes a WebAssembly module of it.
//!
//! An instance holds one run. Numbers are arguments; everything else goes through two buffers of bytes: the caller writes to
//! [`input`] before a call and reads [`output`] after it. A call that can fail returns 0, or the exit code that the program would end
//! with; then the output is the program's message.
//!
//! Workers share a run without sharing memory: each has an instance with the same run, evaluates some of a step's episodes, and is
//! told the fitness of all. An episode's random numbers come from its individual's key, so results don't depend on who evaluates it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::panic;
use std::path::Path;

use oneiro::probe;
use oneiro_base::exit::{Failure, Result};
use oneiro_experiments::EXAMPLES;
use oneiro_lab::experiment::Files;
use oneiro_lab::record::{Finished, InMemory};
use oneiro_lab::runs;
use serde::Deserialize;
use serde_json::json;

/// Arguments of each function of kernels in [`selftest`].
const ARGUMENTS: usize = 1000;

thread_local! {
    static INPUT: RefCell<Vec<u8>> = RefCell::default();
    static OUTPUT: RefCell<Vec<u8>> = RefCell::default();
    static RUN: RefCell<Option<InMemory>> = const { RefCell::new(None) };
    static FINISHED: RefCell<Option<Finished>> = const { RefCell::new(None) };
}

/// What a run is made of: the name and text of an experiment, settings that override it, and the files that it names: those given, and those
/// that ship with it.
#[derive(Deserialize)]
struct Request {
    name: String,
    text: String,
    #[serde(default)]
    set: Vec<String>,
    #[serde(default)]
    files: BTreeMap<String, String>,
}

/// Returns the status of a call, and keeps its output.
fn answered(done: Result<Vec<u8>>) -> u32 {
    let (status, bytes) = match done {
        Ok(bytes) => (0, bytes),
        Err(failure) => (failure.code().into(), failure.to_string().into_bytes()),
    };
    OUTPUT.set(bytes);
    status
}

/// Does something with the run.
fn with_run<T>(work: impl FnOnce(&mut InMemory) -> Result<T>) -> Result<T> {
    RUN.with_borrow_mut(|run| work(run.as_mut().ok_or_else(|| Failure::failed("no run has begun"))?))
}

/// Makes room for so many bytes of input, and returns its address.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn input(length: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|bytes| {
        bytes.resize(length, 0);
        bytes.as_mut_ptr()
    })
}

/// The address of the output of the last call.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn output() -> *const u8 {
    OUTPUT.with_borrow(Vec::as_ptr)
}

/// The number of bytes there.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn output_length() -> usize {
    OUTPUT.with_borrow(Vec::len)
}

/// Output: the shipped experiments, as JSON: of each its `name`, what it is `about`, and its `files`, names and texts, of which the first is the
/// experiment's own. Files that are no texts are left out.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn examples() -> u32 {
    let shipped = EXAMPLES.iter().filter(|example| !example.is_sweep());
    let about = shipped.map(|example| {
        let text = |&(name, bytes): &(&'static str, &'static [u8])| Some((name, str::from_utf8(bytes).ok()?));
        let files: Vec<_> = example.files.iter().filter_map(text).collect();
        json!({ "name": example.name, "about": example.about, "files": files })
    });
    let about: Vec<_> = about.collect();
    answered(Ok(json!(about).to_string().into_bytes()))
}

/// Output: whether this engine computes every operation and function of kernels alike by all codes, as JSON: the codes' names, the number of
/// results that were compared, and for which operations and functions some differ.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn selftest() -> u32 {
    let cases = [probe::operations(), probe::functions(ARGUMENTS)].concat();
    let codes: Vec<&str> = cases[0].lane_codes().collect();
    let (mut compared, mut differing) = (0, Vec::new());
    for case in &cases {
        let results: Vec<Option<Vec<u32>>> = codes.iter().map(|code| case.run(code)).collect();
        if results.windows(2).any(|two| two[0] != two[1] || two[0].is_none()) {
            differing.push(case.subject.to_string());
        }
        compared += case.left.len() * (codes.len() - 1);
    }
    let about = json!({ "codes": codes, "compared": compared, "differing": differing });
    answered(Ok(about.to_string().into_bytes()))
}

/// Begins a run. Input: JSON with the experiment's `name`, `text`, `set` (a list of KEY=VALUE) and `files` (texts by name). Output: JSON.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn open(seed: u64) -> u32 {
    answered(INPUT.with_borrow(|bytes| begun(bytes, seed)))
}

fn begun(bytes: &[u8], seed: u64) -> Result<Vec<u8>> {
    // A panic ends the instance; the page can still read this.
    panic::set_hook(Box::new(|about| {
        OUTPUT.set(format!("a mistake in Oneiro, please report it: {about}").into_bytes());
    }));
    let request: Request =
        serde_json::from_slice(bytes).map_err(|error| Failure::input(format_args!("the request: {error}")))?;
    let shipped = EXAMPLES.iter().filter(|example| example.files[0].0 == request.name);
    let shipped = shipped
        .flat_map(|example| &example.files[1..])
        .map(|&(name, bytes)| (name.to_owned(), bytes.to_vec()));
    let given = request.files.into_iter().map(|(name, text)| (name, text.into_bytes()));
    // Those that are given take the place of others.
    let files: BTreeMap<String, Vec<u8>> = shipped.chain(given).collect();
    let files = Files::given(files.into_iter().map(|(name, bytes)| (name.into(), bytes)).collect());
    let experiment = runs::in_text(Path::new(&request.name), &request.text, &request.set, &files)?;
    let (_, unit) = experiment.shown().time;
    let (_, value) = experiment.shown().value;
    let about = json!({
        "name": experiment.name(),
        "toml": experiment.resolved_toml(seed),
        "warnings": experiment.warnings(),
        "length": experiment.length(),
        "robot_steps": experiment.steps(),
        "unit": unit,
        "value": value,
        "columns": [experiment.shown().time.0, experiment.shown().value.0],
    });
    RUN.set(Some(InMemory::new(experiment, seed)?));
    FINISHED.set(None);
    Ok(about.to_string().into_bytes())
}

/// The number of episodes of the next step that workers may share; 0 if each has to take the step by itself, -1 if the run has taken all.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn shared() -> i32 {
    RUN.with_borrow(|run| {
        let shared = run.as_ref().and_then(InMemory::shared);
        shared.map_or(-1, |episodes| episodes as i32)
    })
}

/// Evaluates episodes `first` to `end`, `end` excluded, of those that are shared. Output: their fitness, 32-bit floats.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn evaluate(first: usize, end: usize) -> u32 {
    let fitness = with_run(|run| run.evaluate(first..end));
    answered(fitness.map(|fitness| fitness.into_iter().flat_map(f32::to_le_bytes).collect()))
}

/// Takes the next step. Input: the fitness of all shared episodes.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn tell() -> u32 {
    let (numbers, _) = INPUT.with_borrow(|bytes| {
        let (words, rest) = bytes.as_chunks::<4>();
        (
            words.iter().copied().map(f32::from_le_bytes).collect::<Vec<_>>(),
            rest.len(),
        )
    });
    answered(with_run(|run| run.tell(&numbers)).map(|()| Vec::new()))
}

/// Takes the next step without others.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn step() -> u32 {
    answered(with_run(InMemory::step).map(|()| Vec::new()))
}

/// Output: steps done, the best fitness, and robot-steps that this instance has simulated, as JSON.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn progress() -> u32 {
    let progress = with_run(|run| {
        let progress = run.progress();
        Ok(json!({ "done": progress.done, "best": progress.best, "robot_steps": run.steps() }))
    });
    answered(progress.map(|progress| progress.to_string().into_bytes()))
}

/// Output: the table of steps so far, as CSV.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn table() -> u32 {
    answered(with_run(|run| Ok(run.table().to_vec())))
}

/// Ends the run. Output: the hash of its results, and the names of its files, as JSON.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn finish() -> u32 {
    let run = RUN.take().ok_or_else(|| Failure::failed("no run has begun"));
    let finished = run.and_then(InMemory::finish);
    answered(finished.map(|finished| {
        let names: Vec<_> = finished.files.iter().map(|(name, _)| name).collect();
        let about = json!({ "result": finished.result, "files": names });
        let bytes = about.to_string().into_bytes();
        FINISHED.set(Some(finished));
        bytes
    }))
}

/// Output: a file of the finished run, by its number among the names.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn file(number: usize) -> u32 {
    let bytes = FINISHED.with_borrow(|finished| {
        let file = finished.as_ref().and_then(|finished| finished.files.get(number));
        file.map(|(_, bytes)| bytes.clone())
    });
    answered(bytes.ok_or_else(|| Failure::failed("the run has no such file")))
}
