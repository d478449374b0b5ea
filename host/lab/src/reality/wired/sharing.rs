//! Episodes that robots share: a free robot takes the next one. A robot that can't go on is set aside, and another one runs its
//! episode. Results are in the order of the episodes, whichever robot ran them and when.

use std::collections::{HashMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::{Life, Lived, Lives, Trouble, Vehicle};

/// Whether a robot takes episodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Standing {
    /// It takes episodes.
    #[default]
    Ready,
    /// It was set aside until it has recovered.
    Aside,
    /// It has failed for good.
    Gone,
}

/// A robot that takes episodes.
pub(super) struct Taker<'a> {
    pub(super) vehicle: &'a mut (dyn Vehicle + Send),
    pub(super) lives: &'a mut Lives,
    pub(super) standing: &'a mut Standing,
}

/// Called with the number of each episode, in the order in which they end.
pub(super) type OnLived<'a> = &'a (dyn Fn(usize, &Lived) + Sync);

/// Runs the episodes on all robots that have not failed for good, and returns the results in the order of `lives`.
///
/// # Errors
/// See [`Trouble`]: the one that stops all robots, or that of the last robot that remained.
pub(super) fn shared(
    takers: Vec<Taker<'_>>,
    lives: &[Life<'_>],
    traced: bool,
    on_lived: OnLived<'_>,
) -> Result<Vec<Lived>, Trouble> {
    let takers: Vec<_> = takers
        .into_iter()
        .filter(|taker| *taker.standing != Standing::Gone)
        .collect();
    let board = Board::new(lives, takers.len());
    thread::scope(|scope| {
        for taker in takers {
            scope.spawn(|| {
                let _watched = Watched(&board);
                taker.work(&board, lives, traced, on_lived);
            });
        }
    });
    board.results()
}

impl Taker<'_> {
    /// Maximum number of times in a row that a robot may lack readings.
    const ATTEMPTS: u32 = 3;

    /// Runs one episode after the other.
    fn work(mut self, board: &Board, lives: &[Life<'_>], traced: bool, on_lived: OnLived<'_>) {
        let mut unread = 0;
        loop {
            if let Err(trouble) = self.recover(board) {
                return self.leave(board, trouble);
            }
            let Some(number) = board.take() else { return };
            let trouble = match self.lives.attempt(self.vehicle, &lives[number], traced) {
                Ok(lived) => {
                    unread = 0;
                    on_lived(number, &lived);
                    board.lived(number, lived);
                    continue;
                }
                Err(trouble) => trouble,
            };
            let is_unread = matches!(trouble, Trouble::Unreadable(_));
            unread = if is_unread { unread + 1 } else { 0 };
            board.give_back(number);
            if !(trouble.may_pass() || matches!(trouble, Trouble::Runaway(_))) || unread == Self::ATTEMPTS {
                return self.leave(board, trouble);
            }
            *self.standing = Standing::Aside;
            let what = if is_unread || board.robots() == 1 {
                "cut short; the episode is repeated"
            } else {
                "set aside; the next free robot takes its episode"
            };
            self.lives.say(&format!("{what}: {trouble}"));
        }
    }

    /// Waits until a robot that was set aside can go on, or until nothing is left to do.
    fn recover(&mut self, board: &Board) -> Result<(), Trouble> {
        if *self.standing == Standing::Aside {
            self.vehicle.recover_until(&|| board.is_over())?;
            if !board.is_over() {
                *self.standing = Standing::Ready;
            }
        }
        Ok(())
    }

    /// Takes no more episodes.
    fn leave(self, board: &Board, trouble: Trouble) {
        if matches!(trouble, Trouble::Stopped | Trouble::Unrecorded(..)) {
            return board.fail(trouble);
        }
        *self.standing = Standing::Gone;
        if board.robots() > 1 {
            self.lives.warn(&format!("takes no more episodes: {trouble}"));
        }
        board.leave(trouble);
    }
}

/// What is left to do.
struct Board {
    state: Mutex<State>,
    changed: Condvar,
    /// For each episode the first identical one: clones with the same random numbers run once, as on one robot, which finds the
    /// first of them on record.
    firsts: Vec<usize>,
}

struct State {
    /// Episodes that no robot has.
    waiting: VecDeque<usize>,
    lived: HashMap<usize, Lived>,
    /// Number of different episodes.
    count: usize,
    /// Robots that take episodes, or may again.
    robots: usize,
    failure: Option<Trouble>,
}

impl State {
    fn is_over(&self) -> bool {
        self.failure.is_some() || self.lived.len() == self.count
    }
}

impl Board {
    fn new(lives: &[Life<'_>], robots: usize) -> Self {
        let mut known = HashMap::new();
        let mut first = |(number, life): (usize, &Life<'_>)| {
            let genes: Vec<u32> = life.genes.iter().map(|gene| gene.to_bits()).collect();
            *known.entry((life.key, genes)).or_insert(number)
        };
        let firsts: Vec<usize> = lives.iter().enumerate().map(&mut first).collect();
        let waiting: VecDeque<usize> = (0..lives.len()).filter(|&number| firsts[number] == number).collect();
        Self {
            state: Mutex::new(State {
                count: waiting.len(),
                waiting,
                lived: HashMap::new(),
                robots,
                failure: (robots == 0).then(|| Trouble::Broken("all robots have failed".into())),
            }),
            changed: Condvar::new(),
            firsts,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    /// The next episode, once there is one; none when all are done.
    fn take(&self) -> Option<usize> {
        let mut state = self.lock();
        loop {
            if state.is_over() {
                return None;
            }
            if let Some(number) = state.waiting.pop_front() {
                return Some(number);
            }
            // Another robot may return its episode.
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn lived(&self, number: usize, lived: Lived) {
        self.change(|state| drop(state.lived.insert(number, lived)));
    }

    fn give_back(&self, number: usize) {
        self.change(|state| state.waiting.push_front(number));
    }

    /// A robot leaves. The last robot's trouble is the failure of all.
    fn leave(&self, trouble: Trouble) {
        self.change(|state| {
            state.robots -= 1;
            if state.robots == 0 {
                state.failure.get_or_insert(trouble);
            }
        });
    }

    /// No robot takes another episode.
    fn fail(&self, trouble: Trouble) {
        self.change(|state| {
            state.failure.get_or_insert(trouble);
        });
    }

    fn is_over(&self) -> bool {
        self.lock().is_over()
    }

    fn robots(&self) -> usize {
        self.lock().robots
    }

    fn results(self) -> Result<Vec<Lived>, Trouble> {
        let State {
            lived, failure, count, ..
        } = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        match failure {
            // A robot may have failed after the last episode.
            Some(failure) if lived.len() < count => Err(failure),
            _ => Ok(self
                .firsts
                .iter()
                .filter_map(|first| lived.get(first).cloned())
                .collect()),
        }
    }
}

/// Lets the other robots end when the thread of one panics, which nobody would notice before they have ended.
struct Watched<'a>(&'a Board);

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.fail(Trouble::Broken("a thread has panicked".into()));
        }
    }
}
