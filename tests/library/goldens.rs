//! Pinned results: every kernel's lives, on every lane code and adapter of this machine, and on an emulated ARM
//! (`tests/aarch64.sh`), match `tests/goldens/kernels/`, so that no bit of them changes unnoticed. [`pinned`] explains
//! how these files are renewed.

use std::path::PathBuf;

use oneiro::backend::Specialise;
use oneiro::batch::{Batch, Trace};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Error, Evaluator};
use oneiro::probe;
use oneiro::tables::{MotorStates, MotorTable, SensorTables};
use oneiro_shader_corpus::CASES;
use oneiro_shaders::{KERNELS, Kernel};

use crate::lives;
use crate::lives::subjects::Subject;
use crate::pinned;
use crate::pinned::Rows;
use crate::skips;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("goldens/kernels")
}

/// Kernels that simulate lives, with their worlds: all except those that compute one function at a time.
fn kernels() -> impl Iterator<Item = (&'static Kernel, Vec<Subject>)> {
    let simulates = KERNELS.iter().filter(|kernel| !kernel.name.starts_with("probe_"));
    simulates.map(|kernel| {
        let subjects = lives::subjects::of_kernel(kernel.name);
        assert!(!subjects.is_empty(), "no world of the kernel {} is pinned", kernel.name);
        for subject in &subjects {
            assert_eq!(subject.worlds.kernel().name, kernel.name, "{}", subject.name);
        }
        (*kernel, subjects)
    })
}

/// Results of lives: the bits of their fitness, and of their traces.
#[derive(PartialEq, Eq)]
struct Lived {
    fitness: Vec<u32>,
    trace: Vec<u32>,
}

/// Results of a batch on a device; `None` if the batch is too large for it.
fn lived(batch: &Batch, evaluator: &mut dyn Evaluator) -> Option<Lived> {
    let outcome = match evaluator.evaluate(batch, &Control::new()) {
        Ok(outcome) => outcome,
        Err(Error::TooLarge(_)) => return None,
        Err(error) => panic!("{error}"),
    };
    let mut trace: Vec<u32> = outcome.traces.iter().flat_map(Trace::words).collect();
    trace.extend(outcome.logs.concat());
    Some(Lived {
        fitness: outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect(),
        trace,
    })
}

/// The rows of one kernel.
fn rows(kernel: &Kernel, subjects: &[Subject], batches: &[Batch], lives: &[Lived]) -> Rows {
    let mut rows = Rows::default();
    rows.words("kernel", kernel.name, kernel.spirv);
    rows.words("tables", &subjects[0].name, batches[0].all().tables().as_flattened());
    let genes: Vec<f32> = subjects.iter().flat_map(|subject| subject.genomes.concat()).collect();
    rows.numbers("genes", "all", &genes);
    for (subject, lived) in subjects.iter().zip(lives) {
        let fitness: Vec<f32> = lived.fitness.iter().map(|&bits| f32::from_bits(bits)).collect();
        rows.numbers("fitness", &subject.name, &fitness);
    }
    for (subject, lived) in subjects.iter().zip(lives) {
        rows.words("trace", &subject.name, &lived.trace);
    }
    let all: Vec<u32> = lives
        .iter()
        .flat_map(|lived| lived.fitness.iter().chain(&lived.trace).copied())
        .collect();
    rows.words("end", "all", &all);
    rows
}

/// Describes where the results of one device differ from those of another.
fn difference(found: &Lived, expected: &Lived) -> String {
    for (stage, found, expected) in [
        ("fitness", &found.fitness, &expected.fitness),
        ("trace", &found.trace, &expected.trace),
    ] {
        if let Some(index) = found
            .iter()
            .zip(expected)
            .position(|(found, expected)| found != expected)
        {
            let words = found.len();
            return format!(
                "word {index} of {words} of its {stage} is {:08x}, not {:08x}",
                found[index], expected[index]
            );
        }
    }
    "its lengths differ".to_owned()
}

/// Cycles between records of a trace: few enough to see each stretch of a life, and prime, so that it divides no length.
const EVERY: u32 = 7;

/// Whether lane code is compiled at run time too.
const NATIVE: bool = cfg!(all(
    feature = "native",
    any(target_arch = "x86_64", target_arch = "aarch64")
));

/// The lane code that is compiled at run time on every processor for which there is one.
const NATIVE_CODE: &str = "native128x16";
/// The interpreter, a hundred times as slow as the slowest lane code.
const INTERPRETER: &str = "interpretedx1";
/// Whether the processor is emulated.
const EMULATED: bool = cfg!(target_arch = "aarch64");
/// Of how many worlds what is slow lives in one, unless `ONEIRO_LONG` is set.
const SHARE: usize = if EMULATED { 64 } else { 8 };
/// The same for what an emulated processor runs. Its fastest lane code, the first, lives in all of them.
const EMULATED_SHARE: usize = 4;

/// What the names of devices end with whose kernels are compiled for each world.
const SPECIALISED: &str = ", specialised";

/// The CPU with one lane code.
fn lane_code(name: &'static str) -> (String, Box<dyn Evaluator>) {
    let cpu = Cpu::new(None).and_then(|cpu| cpu.with_variant(name));
    (name.to_owned(), Box::new(cpu.expect("it is available")))
}

/// Devices that must agree, by name.
fn devices() -> Vec<(String, Box<dyn Evaluator>)> {
    let lane_codes: Vec<_> = Cpu::variants().into_iter().map(lane_code).collect();
    assert!(
        lane_codes.iter().any(|(name, _)| name.starts_with("checked")),
        "the lane code that traps is not there"
    );
    // Compiled at run time, where the library can.
    let has_native = lane_codes.iter().any(|(name, _)| name == NATIVE_CODE);
    assert_eq!(has_native, NATIVE, "{:?}", Cpu::variants());
    // Compiled for the world at hand.
    let natives = Cpu::variants().into_iter().filter(|name| name.starts_with("native"));
    let specialised = natives.map(|name| {
        let cpu = Cpu::new(None).and_then(|cpu| cpu.with_variant(name));
        let cpu = cpu.expect("it is available").with_specialise(Specialise::Always);
        (name.to_owned() + SPECIALISED, Box::new(cpu) as Box<dyn Evaluator>)
    });
    lane_codes.into_iter().chain(specialised).chain(adapters()).collect()
}

#[cfg(not(feature = "gpu"))]
fn adapters() -> Vec<(String, Box<dyn Evaluator>)> {
    Vec::new()
}

#[cfg(feature = "gpu")]
fn adapters() -> Vec<(String, Box<dyn Evaluator>)> {
    let adapters = oneiro::gpu::adapters();
    assert!(!adapters.is_empty(), "these tests need an adapter");
    let mut exact: Vec<(String, Box<dyn Evaluator>)> = Vec::new();
    for adapter in adapters {
        let gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Named(adapter.index().to_string()));
        let gpu = gpu.expect("an adapter that can be opened");
        match gpu.why_inexact() {
            None => {
                let name = adapter.name().to_owned();
                // Kernels that are compiled for the world at hand.
                let mut specialised = oneiro::gpu::Gpu::open_with(&adapter, oneiro::gpu::Path::Spirv).expect("again");
                specialised.set_specialise(Specialise::Always);
                exact.push((name.clone() + SPECIALISED, Box::new(specialised)));
                exact.push((name, Box::new(gpu)));
            }
            Some(why) => skips::skipped("exact-adapter", &format!("{}: {why}", adapter.name())),
        }
    }
    exact
}

#[test]
fn lives_are_as_pinned() {
    let mut devices = devices();
    if cfg!(feature = "compose") {
        devices.push(lane_code(INTERPRETER));
    }
    let mut files = ["tables.rows", "corpus.rows", "functions.rows", "long.rows"]
        .map(str::to_owned)
        .to_vec();
    let mut problems = Vec::new();
    for (kernel, subjects) in kernels() {
        let batches: Vec<Batch> = subjects.iter().map(|subject| subject.batch(EVERY)).collect();
        let (first, others) = devices.split_first_mut().expect("a lane code");
        let expected: Vec<Lived> = batches
            .iter()
            .map(|batch| lived(batch, &mut *first.1).expect("what a CPU has room for"))
            .collect();
        // If two worlds had equal lives, one of them would pin nothing.
        for (index, lived) in expected.iter().enumerate() {
            let same = expected[..index].iter().position(|other| other.trace == lived.trace);
            let name = |index: usize| &subjects[index].name;
            assert_eq!(same.map(name), None, "{}: as in {}", kernel.name, name(index));
        }
        let file = format!("{}.rows", kernel.name);
        let found = rows(kernel, &subjects, &batches, &expected).to_string();
        problems.extend(pinned::problem(&folder().join(&file), &found));
        files.push(file);
        for (device, evaluator) in others {
            // What traps computes as the scalar code does, and is emulated slowest of all.
            let is_slow =
                EMULATED && device.starts_with("checked") || device == INTERPRETER || device.ends_with(SPECIALISED);
            let share = if std::env::var_os("ONEIRO_LONG").is_some() {
                1
            } else if is_slow {
                SHARE
            } else if EMULATED {
                EMULATED_SHARE
            } else {
                1
            };
            let lives = subjects.iter().zip(&batches).zip(&expected);
            for ((subject, batch), expected) in lives.step_by(share) {
                let Some(found) = lived(batch, &mut **evaluator) else {
                    println!("{device} is too small for {}: {}", kernel.name, subject.name);
                    continue;
                };
                if found != *expected {
                    let difference = difference(&found, expected);
                    problems.push(format!(
                        "{}: {}: {device} and {} differ: {difference}",
                        kernel.name, subject.name, first.0
                    ));
                }
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    pinned::check_folder(&folder(), &files);
}

/// The first world of each kernel for hours of simulated time, wherever it fits.
#[test]
#[ignore = "takes minutes: tests/long.sh runs it"]
fn long_lives_are_as_pinned() {
    let mut devices = devices();
    let mut rows = Rows::default();
    for (kernel, subject) in lives::subjects::long() {
        let mut expected = None;
        let batch = subject.batch(1_000);
        for (device, evaluator) in &mut devices {
            let Some(found) = lived(&batch, &mut **evaluator) else {
                continue;
            };
            let Some(expected) = &expected else {
                rows.words("fitness", kernel, &found.fitness);
                rows.words("trace", kernel, &found.trace);
                expected = Some(found);
                continue;
            };
            assert!(
                found == *expected,
                "{kernel}: {device}: {}",
                difference(&found, expected)
            );
        }
    }
    pinned::check(&folder().join("long.rows"), &rows.to_string());
}

/// The compiled-in tables.
#[test]
fn tables_are_as_pinned() {
    let mut rows = Rows::default();
    for class in &SensorTables::khepera().classes {
        let readings = class.readings.iter().map(|&reading| u32::from(reading));
        rows.words("sensors", &class.class, &readings.collect::<Vec<_>>());
    }
    for (name, states) in [
        ("symmetric 20", MotorStates::Symmetric20),
        ("asymmetric 20", MotorStates::Asymmetric20),
        ("Evorobot 21", MotorStates::Evorobot21),
    ] {
        let cells = MotorTable::khepera(states).cells.clone();
        let numbers = cells
            .iter()
            .flat_map(|cell| [cell.displacement, cell.turn, cell.left, cell.right]);
        rows.numbers("motors", name, &numbers.collect::<Vec<_>>());
    }
    pinned::check(&folder().join("tables.rows"), &rows.to_string());
}

/// The functions that kernels compute with, on every lane code.
#[test]
fn functions_are_as_pinned() {
    let mut rows = Rows::default();
    for case in probe::functions(1 << 12) {
        let results: Vec<_> = case.lane_codes().filter_map(|variant| case.run(variant)).collect();
        assert!(results.iter().all(|other| *other == results[0]), "{}", case.subject);
        rows.words("function", &case.subject.to_string(), &results[0]);
    }
    pinned::check(&folder().join("functions.rows"), &rows.to_string());
}

/// Results of the compiler's interpreter on the corpus; other tests compare lane code and SPIR-V with them.
#[test]
fn the_corpus_is_as_pinned() {
    let mut rows = Rows::default();
    for case in CASES {
        rows.words("case", case.kernel.name, &case.after.concat());
    }
    pinned::check(&folder().join("corpus.rows"), &rows.to_string());
}

/// Negative controls: a change of pinned results is detected, and nothing is renewed by accident.
mod controls {
    use crate::pinned::{Renewal, Rows, all_used, compared};
    use std::fs;
    use std::path::{Path, PathBuf};

    fn rows(fitness: &[f32]) -> String {
        let mut rows = Rows::default();
        rows.numbers("genes", "all", &[0.5]);
        rows.numbers("fitness", "no noise", fitness);
        rows.words("end", "all", &fitness.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
        rows.to_string()
    }

    /// A folder for one control, with an accepted golden file.
    fn accepted(control: &str) -> PathBuf {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("goldens").join(control);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("kept.rows");
        accept(&file, &rows(&[1.0, 2.0]), "the first");
        file
    }

    fn accept(file: &Path, found: &str, reason: &str) {
        let reason = Some(reason.to_owned());
        compared(file, found, &Renewal::default()).unwrap_err();
        let message = compared(file, found, &Renewal { ci: false, reason }).unwrap_err();
        assert!(message.contains("accepted: "), "{message}");
        compared(file, found, &Renewal::default()).unwrap();
    }

    fn new(file: &Path) -> PathBuf {
        file.with_extension("rows.new")
    }

    #[test]
    fn one_changed_bit_is_located() {
        let file = accepted("bit");
        let changed = rows(&[1.0, 2.0_f32.next_up()]);
        let message = compared(&file, &changed, &Renewal::default()).unwrap_err();
        assert!(message.contains("the first difference is in fitness"), "{message}");
        for row in rows(&[1.0, 2.0]).lines().skip(1) {
            assert!(message.contains(&format!("old: {row}")), "{message}");
        }
        for row in changed.lines().skip(1) {
            assert!(message.contains(&format!("new: {row}")), "{message}");
        }
        assert!(!message.contains("genes"), "{message}");
        // The new rows are written beside the old ones, which stay until everything is as before.
        assert_eq!(fs::read_to_string(new(&file)).unwrap(), changed);
        assert_eq!(fs::read_to_string(&file).unwrap(), rows(&[1.0, 2.0]));
        compared(&file, &rows(&[1.0, 2.0]), &Renewal::default()).unwrap();
        assert!(!new(&file).exists());
    }

    #[test]
    fn unused_rows_are_detected() {
        let file = accepted("unused");
        let fewer: String = rows(&[1.0, 2.0]).lines().skip(1).flat_map(|row| [row, "\n"]).collect();
        let message = compared(&file, &fewer, &Renewal::default()).unwrap_err();
        assert!(message.contains("nothing uses: genes | all"), "{message}");
        let folder = file.parent().unwrap();
        let used = ["kept.rows".to_owned()];
        all_used(folder, &used).unwrap();
        fs::write(folder.join("other.rows"), "").unwrap();
        assert!(all_used(folder, &used).unwrap_err().contains("other.rows"));
    }

    #[test]
    fn continuous_integration_writes_nothing() {
        let file = accepted("ci");
        for reason in [None, Some("it is right".to_owned())] {
            compared(&file, &rows(&[3.0]), &Renewal { ci: true, reason }).unwrap_err();
            assert!(!new(&file).exists());
        }
        assert_eq!(fs::read_to_string(&file).unwrap(), rows(&[1.0, 2.0]));
    }

    #[test]
    fn nothing_is_accepted_unseen_or_by_hand() {
        let file = accepted("reason");
        let renewal = |reason: &str| Renewal {
            ci: false,
            reason: Some(reason.to_owned()),
        };
        // The first run shows the difference; a run that finds yet another one shows that instead.
        compared(&file, &rows(&[3.0]), &renewal("it is right")).unwrap_err();
        compared(&file, &rows(&[4.0]), &renewal("it is right")).unwrap_err();
        assert_eq!(fs::read_to_string(&file).unwrap(), rows(&[1.0, 2.0]));
        compared(&file, &rows(&[4.0]), &renewal("it is right")).unwrap_err();
        assert_eq!(fs::read_to_string(&file).unwrap(), rows(&[4.0]));
        let log = fs::read_to_string(file.with_file_name("CHANGES.md")).unwrap();
        let last = log.lines().last().unwrap();
        assert!(last.ends_with(": it is right (1 end, 1 fitness)"), "{log}");
        assert!(log.contains("the first"), "{log}");
        // A file that was edited by hand counts as not accepted.
        fs::write(&file, rows(&[5.0])).unwrap();
        let message = compared(&file, &rows(&[5.0]), &Renewal::default()).unwrap_err();
        assert!(message.contains("changed by hand"), "{message}");
    }
}
