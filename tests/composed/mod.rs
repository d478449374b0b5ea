//! Pinned results of kernels that are composed at run time, and the same bits on all devices: each feature has subjects, whose episodes
//! reach all of its code, and a file in `tests/goldens/composed/`.

use std::path::Path;

use oneiro::backend::Specialise;
use oneiro::batch::{Batch, Trace};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};

use crate::pinned;

/// Episodes in a world.
pub(crate) struct Subject {
    name: String,
    whole: Batch,
    /// The first episodes alone, for devices that are a hundred times as slow.
    few: Option<Batch>,
    is_for_gpu: bool,
    is_specialised: bool,
}

impl Subject {
    /// `batch` makes the batch of the first episodes, as many as it is given. Of a large world, `few` may be 0.
    pub(crate) fn new(name: impl Into<String>, episodes: usize, few: usize, batch: impl Fn(usize) -> Batch) -> Self {
        Self {
            name: name.into(),
            whole: batch(episodes),
            few: (few > 0).then(|| batch(few)),
            is_for_gpu: true,
            is_specialised: true,
        }
    }

    /// The same on processors alone: a software driver takes seconds to compile some kernels.
    pub(crate) fn without_gpu(mut self) -> Self {
        self.is_for_gpu = false;
        self
    }

    /// The same without code for this world, which takes seconds to compile for large ones.
    pub(crate) fn without_specialising(mut self) -> Self {
        self.is_specialised = false;
        self
    }
}

/// The fitness and the words of the traces of a batch's episodes.
fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> (Vec<f32>, Vec<u32>) {
    let outcome = evaluator.evaluate(batch, &Control::new()).expect("a valid batch");
    let words = outcome.traces.iter().flat_map(Trace::words).collect();
    (outcome.fitness, words)
}

/// Compares all devices with each other, and the results with the pinned ones of a feature's file.
pub(crate) fn check(rows_file: &str, subjects: &[Subject]) {
    let cpu = || Cpu::new(Some(2)).expect("two threads");
    let code = |when| Box::new(cpu().with_specialise(when)) as Box<dyn Evaluator>;
    let cut = Cpu::new(Some(1)).expect("a thread").with_chunk(7);
    let mut devices = [
        ("code for any world", code(Specialise::Never)),
        (
            "one thread, in stretches of 7 cycles",
            Box::new(cut) as Box<dyn Evaluator>,
        ),
    ];
    let mut specialised = [("code for this world", code(Specialise::Always))];
    #[cfg(feature = "gpu")]
    let mut gpu: [(_, Box<dyn Evaluator>); 1] = {
        let gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter");
        [("a GPU", Box::new(gpu))]
    };
    let interpreted = cpu().with_variant("interpretedx1").expect("it is everywhere");
    let mut slow: [(_, Box<dyn Evaluator>); 2] = [
        ("the interpreter", Box::new(interpreted)),
        ("the interpreter with its checks", Box::new(cpu().checking())),
    ];
    let mut rows = pinned::Rows::default();
    for subject in subjects {
        let usual = |batch| evaluated(&mut cpu(), batch);
        let compare = |devices: &mut [(&str, Box<dyn Evaluator>)], batch: &Batch, expected: &(Vec<f32>, Vec<u32>)| {
            for (device, evaluator) in devices {
                let found = evaluated(&mut **evaluator, batch);
                let bits = |fitness: &[f32]| fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>();
                let name = &subject.name;
                assert_eq!(bits(&found.0), bits(&expected.0), "{rows_file}, {name}: {device}");
                assert!(found.1 == expected.1, "{rows_file}, {name}: {device} traces otherwise");
            }
        };
        let expected = usual(&subject.whole);
        compare(&mut devices, &subject.whole, &expected);
        if subject.is_specialised {
            compare(&mut specialised, &subject.whole, &expected);
        }
        #[cfg(feature = "gpu")]
        if subject.is_for_gpu {
            compare(&mut gpu, &subject.whole, &expected);
        }
        if let Some(few) = &subject.few {
            compare(&mut slow, few, &usual(few));
        }
        rows.numbers("fitness", &subject.name, &expected.0);
        rows.words("trace", &subject.name, &expected.1);
    }
    if let Some(problem) = pinned::problem(Path::new(rows_file), &rows.to_string()) {
        panic!("{problem}");
    }
}
