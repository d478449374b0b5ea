//! How the program ends when it can't continue: too little memory, too few threads, a panic, a crash in a library. It
//! always prints a sentence and ends with an exit code of `docs/commands.md`. Earlier records are complete, as after any
//! kill.

use std::alloc::{GlobalAlloc, Layout};
use std::io::Write as _;
use std::panic::{self, PanicHookInfo, UnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::console::Console;
use crate::exit::{Code, Failure, Result, complete};

/// Said where memory or threads run out.
const SHORT: &str = concat!(
    "oneiro: not enough memory or threads. Allow more (ulimit -v, -s, -u), or use fewer --threads, or --backend cpu, which loads no \
     graphics driver. ",
    complete!(),
    "\n"
);
/// Said of a crash.
const CRASHED: &str = concat!(
    "oneiro: a crash in Oneiro, or in a library such as a graphics driver; --backend cpu loads no driver. Please \
     report it with the command. ",
    complete!(),
    "\n"
);
/// Said where the user stops a command before its work.
#[cfg(unix)]
const NOT_BEGUN: &str = "oneiro: stopped before the work began; run the same command again\n";

/// Whether the allocator has had no memory for something large.
static HAD_NO_MEMORY: AtomicBool = AtomicBool::new(false);

/// An allocator that ends the program where memory runs out, with exit code 7. It refuses pieces of 1 MB and more instead, since who
/// asks for those can say more.
pub struct Ending<A>(pub A);

/// Size of a large piece.
const LARGE: usize = 1 << 20;

/// Passes on what an allocator gave for `size` bytes.
#[inline]
fn given(memory: *mut u8, size: usize) -> *mut u8 {
    if memory.is_null() {
        refused(size);
    }
    memory
}

#[cold]
fn refused(size: usize) {
    if size < LARGE {
        end_at_once(SHORT, Code::Memory as u8);
    }
    HAD_NO_MEMORY.store(true, Ordering::Relaxed);
}

// SAFETY: all memory is the inner allocator's.
unsafe impl<A: GlobalAlloc> GlobalAlloc for Ending<A> {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        given(unsafe { self.0.alloc(layout) }, layout.size())
    }

    #[inline]
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { self.0.dealloc(memory, layout) };
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        given(unsafe { self.0.alloc_zeroed(layout) }, layout.size())
    }

    #[inline]
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller promises.
        given(unsafe { self.0.realloc(memory, layout, size) }, size)
    }
}

/// From now on, a panic reports its place, and endings from within report their reason. Call before starting any
/// thread.
pub fn prepare() {
    panic::set_hook(Box::new(panicked));
    #[cfg(unix)]
    unix::prepare();
}

/// Reports a panic, and ends the program if memory or threads are missing: unwinding may need more of them.
fn panicked(panic: &PanicHookInfo<'_>) {
    let message = panic.payload_as_str().unwrap_or("no reason given");
    if is_want(message) {
        end_at_once(SHORT, Code::Memory as u8);
    }
    let place = panic
        .location()
        .map_or_else(String::new, |place| format!(" at {place}"));
    let console = Console::default();
    console.ask(format!("oneiro: panicked{place}: {message}"));
    if std::env::var_os("RUST_BACKTRACE").is_some_and(|wanted| wanted != "0") {
        console.ask(std::backtrace::Backtrace::force_capture().to_string());
    }
}

/// Whether a panic with this message means missing memory or threads. The standard library and rayon panic with these
/// words where no thread can be started.
fn is_want(message: &str) -> bool {
    const THREADS: [&str; 2] = ["failed to spawn thread", "ThreadPoolBuildError"];
    THREADS.iter().any(|words| message.contains(words)) || is_short()
}

/// Ends the program at a signal, before its work has begun.
#[cfg(unix)]
pub fn stopped_early() -> ! {
    end_at_once(NOT_BEGUN, Code::Stopped as u8)
}

/// Does what the program is to do, and prints why it failed. Returns its exit code.
pub fn code_of(console: Console, command: impl FnOnce() -> Result + UnwindSafe) -> u8 {
    // A panic's own message was printed when it happened.
    let done = panic::catch_unwind(command).unwrap_or_else(|_| Err(Failure::broken("the command")));
    let Err(failure) = done else { return 0 };
    if !matches!(failure, Failure::BrokenPipe) {
        console.fail(&failure);
    }
    failure.code()
}

/// Ends the program at once with an exit code if the user stopped it, or if `settles` returns that nobody needs the background work: a
/// driver can't be stopped. Else returns the code.
#[cfg_attr(
    not(test),
    expect(clippy::disallowed_methods, reason = "it flushes earlier output, and shows nothing")
)]
pub fn end(code: u8, settles: impl FnOnce() -> bool) -> u8 {
    if cfg!(unix) && (code == Code::Stopped as u8 || settles()) {
        let _ = std::io::stdout().flush();
        end_at_once("", code);
    }
    code
}

#[cfg(not(unix))]
fn is_short() -> bool {
    false
}

#[cfg(not(unix))]
fn end_at_once(text: &str, code: u8) -> ! {
    let _ = std::io::stderr().write_all(text.as_bytes());
    std::process::exit(code.into())
}

#[cfg(unix)]
use unix::{end_at_once, is_short};

/// All here may be called from a signal handler.
#[cfg(unix)]
mod unix {
    use std::sync::atomic::Ordering;
    use std::{mem, ptr};

    use super::{CRASHED, HAD_NO_MEMORY, SHORT};
    use crate::exit::Code;

    /// If less than this can be had, memory is short.
    const LITTLE: usize = 256 << 20;
    /// Minimum stack of the first thread.
    const STACK: libc::rlim_t = 1 << 20;

    /// Registers what ends the program where it, or a library, aborts or touches memory that isn't there. From now on a file that
    /// grows beyond `ulimit -f` is an error, and no signal.
    pub(super) fn prepare() {
        // SAFETY: no function is called.
        unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
        // SAFETY: an action of zeros has no flags, and blocks no signals.
        let mut action: libc::sigaction = unsafe { mem::zeroed() };
        action.sa_sigaction = ended as extern "C" fn(libc::c_int) as libc::sighandler_t;
        // On a thread's own stack for signals, since its stack may be what is full.
        action.sa_flags = libc::SA_ONSTACK;
        for of_crash in [libc::SIGABRT, libc::SIGSEGV, libc::SIGBUS, libc::SIGILL, libc::SIGFPE] {
            // SAFETY: the handler only calls what signal handlers may call. If it can't be registered, the system's stays.
            unsafe { libc::sigaction(of_crash, &raw const action, ptr::null_mut()) };
        }
    }

    extern "C" fn ended(_: libc::c_int) {
        if HAD_NO_MEMORY.load(Ordering::Relaxed) || is_short() {
            end_at_once(SHORT, Code::Memory as u8);
        }
        end_at_once(CRASHED, Code::Broken as u8);
    }

    /// Whether memory has run out or is about to, or the stack can't grow as far as the program needs.
    pub(super) fn is_short() -> bool {
        let mut stack = libc::rlimit {
            rlim_cur: 0,
            rlim_max: 0,
        };
        // SAFETY: asks for a limit, and makes a new mapping that nobody uses.
        let has_both = unsafe {
            let (protection, flags) = (
                libc::PROT_READ | libc::PROT_WRITE,
                libc::MAP_PRIVATE | libc::MAP_ANONYMOUS,
            );
            let memory = libc::mmap(ptr::null_mut(), LITTLE, protection, flags, -1, 0);
            memory != libc::MAP_FAILED
                && libc::munmap(memory, LITTLE) == 0
                && libc::getrlimit(libc::RLIMIT_STACK, &raw mut stack) == 0
                && stack.rlim_cur >= STACK
        };
        !has_both
    }

    /// Ends the program with a text on standard error.
    pub(super) fn end_at_once(text: &str, code: u8) -> ! {
        /// Clears the line of a progress bar.
        const CLEARED: &str = "\r\x1b[2K";
        // SAFETY: the pointers and lengths are those of texts; nothing of the process is used after the last call.
        unsafe {
            let write = |text: &str| libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len());
            if libc::isatty(libc::STDERR_FILENO) == 1 {
                write(CLEARED);
            }
            write(text);
            libc::_exit(code.into())
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::process::Command;
    use std::thread;

    use super::*;

    /// Set where this test's own process is to end.
    const WAY: &str = "ONEIRO_ENDING";

    /// A panic of the command, one of another thread that it waits for, one by a missing thread, a crash and an abort
    /// each end with their code and their sentence. Each happens in another process.
    #[test]
    fn whatever_happens_ends_with_a_code_and_a_sentence() {
        if let Ok(way) = std::env::var(WAY) {
            end_by(&way);
        }
        let name = thread::current().name().unwrap().to_owned();
        let program = std::env::current_exe().unwrap();
        for (way, code, sentences) in [
            (
                "panic",
                70,
                &[
                    "oneiro: panicked at ",
                    "on purpose",
                    "oneiro: the command panicked",
                    "`oneiro resume`",
                ][..],
            ),
            ("thread", 70, &["on purpose", "oneiro: the command panicked"]),
            (
                "threads",
                7,
                &["oneiro: not enough memory or threads", "`oneiro resume`"],
            ),
            ("crash", 70, &["oneiro: a crash in Oneiro", "`oneiro resume`"]),
            ("abort", 70, &["oneiro: a crash in Oneiro"]),
            ("nothing", 0, &[]),
        ] {
            let alone = Command::new(&program)
                .args(["--exact", &name, "--nocapture"])
                .env(WAY, way)
                .env_remove("RUST_BACKTRACE")
                .output()
                .unwrap();
            let said = String::from_utf8(alone.stderr).unwrap();
            assert_eq!(alone.status.code(), Some(code), "{way}: {said}");
            assert!(sentences.iter().all(|words| said.contains(words)), "{way}: {said}");
        }
    }

    fn end_by(way: &str) -> ! {
        prepare();
        let way = way.to_owned();
        let code = code_of(Console::default(), move || {
            match way.as_str() {
                "panic" => panic!("on purpose"),
                "thread" => thread::scope(|scope| scope.spawn(|| panic!("on purpose")).join().unwrap()),
                "threads" => panic!("failed to spawn thread: of another kind"),
                // SAFETY: the handler ends the process.
                "crash" => unsafe { std::ptr::null_mut::<u8>().write_volatile(0) },
                "abort" => std::process::abort(),
                _ => (),
            }
            Ok(())
        });
        std::process::exit(code.into())
    }
}
