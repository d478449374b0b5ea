//! Kernels run by the compiler's interpreter, where they can't be compiled at run time: slow, and the same bits.

mod ranges;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use oneiro_shader_compiler::interpret::{self, Breach, Buffers, Trap};
use oneiro_shader_compiler::{Part, Place, Trees, trees};
use oneiro_shaders::{Kernel, Words};

use crate::evaluator::Error;
use crate::parts::compose;

/// One lane.
pub(crate) const NAME: &str = "interpretedx1";

/// A kernel's program.
#[derive(Clone, Debug)]
pub(crate) struct Code {
    trees: Arc<Trees>,
    kernel: &'static Kernel,
    /// Whether operations are checked.
    checks: bool,
}

/// Whether kernels can be interpreted.
pub(crate) fn is_available() -> bool {
    true
}

/// Returns a kernel's program.
///
/// # Errors
/// [`Error::NoDevice`] if its text is refused.
pub(crate) fn compiled(kernel: &'static Kernel) -> Result<Code, Error> {
    static PROGRAMS: Mutex<BTreeMap<&str, Code>> = Mutex::new(BTreeMap::new());
    // A poisoned lock is fine: entries are added complete or not at all.
    let mut programs = PROGRAMS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(code) = programs.get(kernel.name) {
        return Ok(code.clone());
    }
    let part = Part {
        path: format!("{}.wgsl", kernel.name),
        text: kernel.wgsl.into(),
    };
    let refused = |problem| Error::NoDevice(format!("the kernel {} can't be interpreted: {problem}", kernel.name));
    let code = Code {
        trees: Arc::new(trees(&[part]).map_err(|refusals| refused(refusals[0].to_string()))?),
        kernel,
        checks: false,
    };
    programs.insert(kernel.name, code.clone());
    Ok(code)
}

/// Returns a kernel's program, of which each operation is checked, and each argument that has a range.
///
/// # Errors
/// As [`compiled`].
pub(crate) fn checked(kernel: &'static Kernel) -> Result<Code, Error> {
    // Other texts have no names of files.
    let parts = ranges::checked(compose::parts_of(kernel));
    let trees = trees(&parts).map_err(|refusals| Error::NoDevice(refusals[0].to_string()))?;
    Ok(Code {
        trees: Arc::new(trees),
        kernel,
        checks: true,
    })
}

impl Code {
    #[expect(clippy::unused_self, reason = "as that of code compiled at run time")]
    pub(crate) fn name(&self) -> &'static str {
        NAME
    }

    /// Number of lanes that a call runs.
    #[expect(clippy::unused_self, reason = "as that of code compiled at run time")]
    pub(crate) fn lanes(&self) -> u32 {
        1
    }

    /// Runs one lane of a workgroup.
    ///
    /// # Errors
    /// [`Error::Unbounded`] if its loops turn more than `turns` times in all. [`Error::Inexact`] if operations are checked
    /// and one of them is inexact.
    ///
    /// # Safety
    /// As [`super::LaneCode::run`].
    pub(crate) unsafe fn run(&self, buffers: &[Words], workgroup: u32, lane: u32, turns: u64) -> Result<(), Error> {
        let strides = &self.trees.strides;
        let mut memory = Shared { buffers, strides };
        let done = if self.checks {
            // Tidied programs have other operations.
            interpret::run_checked(&self.trees.raw, &mut memory, workgroup, lane, turns)
        } else {
            interpret::run(&self.trees.tidied, &mut memory, workgroup, lane, turns).map(|()| None)
        };
        match done {
            Err(Trap::Endless) => Err(Error::Unbounded {
                kernel: self.kernel.name.to_owned(),
                turns,
            }),
            done => match done.expect("kernels that compile set each value before they use it") {
                Some(breach) => Err(self.inexact(&breach)),
                None => Ok(()),
            },
        }
    }

    /// The error of a breach. If it is in a function that a user's part calls, its place is that of the call.
    fn inexact(&self, breach: &Breach) -> Error {
        let places: Vec<_> = self.trees.places(breach.value).collect();
        let is_of_user = |place: &&Place| compose::is_of_user(self.kernel, &place.path);
        let place = places.iter().find(is_of_user).unwrap_or(&places[0]);
        if let Some(what) = ranges::breach(&places[0], &breach.what) {
            let place = place.to_string();
            return Error::Inexact { place, what };
        }
        let called = if *place == places[0] {
            String::new()
        } else {
            format!("in {}: ", places[0])
        };
        Error::Inexact {
            place: place.to_string(),
            what: called + &breach.what,
        }
    }
}

/// The buffers of a call, in which others run their own lanes meanwhile.
struct Shared<'a> {
    buffers: &'a [Words],
    strides: &'a [u32],
}

impl Shared<'_> {
    /// The address of a word.
    fn at(&self, buffer: u32, index: usize) -> *mut u32 {
        let words = &self.buffers[buffer as usize];
        assert!(index < words.len, "word {index} of {}", words.len);
        // SAFETY: the word is one of the buffer's.
        unsafe { words.start.add(index) }
    }
}

impl Buffers for Shared<'_> {
    fn elements(&self, buffer: u32) -> u32 {
        self.buffers[buffer as usize].len as u32 / self.strides[buffer as usize]
    }

    fn load(&self, buffer: u32, index: usize) -> u32 {
        // SAFETY: the caller of `Code::run` guarantees that it is valid and that nobody writes it meanwhile.
        unsafe { self.at(buffer, index).read() }
    }

    fn store(&mut self, buffer: u32, index: usize, value: u32) {
        // SAFETY: the caller of `Code::run` guarantees that buffers which the kernel writes are valid for writes, and that
        // nobody else accesses the words that this lane writes.
        unsafe { self.at(buffer, index).write(value) };
    }
}
