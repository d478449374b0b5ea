//! A link on a virtual clock whose other end follows a script, and random bytes for parsers. For tests.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::error::{Error, Result};
use super::link::{Clock, Link};
use super::vehicle::direct;

/// What the other end does next.
#[derive(Clone, Debug)]
pub enum Step {
    /// Waits for exactly these bytes.
    Hear(Vec<u8>),
    /// Sends bytes, this long after the step before.
    Say(Duration, Vec<u8>),
    /// Closes the link.
    HangUp,
    /// Accepts that the link is opened again.
    Reopen,
}

/// Hears bytes.
pub fn hear(bytes: impl AsRef<[u8]>) -> Step {
    Step::Hear(bytes.as_ref().to_vec())
}

/// Sends bytes after 10 ms.
pub fn say(bytes: impl AsRef<[u8]>) -> Step {
    say_after(10, bytes)
}

/// Sends bytes after some milliseconds.
pub fn say_after(ms: u64, bytes: impl AsRef<[u8]>) -> Step {
    Step::Say(Duration::from_millis(ms), bytes.as_ref().to_vec())
}

/// The hand of a clock, in microseconds.
#[derive(Clone, Debug)]
pub struct Hand(Arc<AtomicU64>);

impl Hand {
    fn at(ms: u64) -> Self {
        Self(Arc::new(AtomicU64::new(1000 * ms)))
    }

    /// Lets time pass while nobody listens.
    pub fn advance(&self, ms: u64) {
        self.0.fetch_add(1000 * ms, Ordering::Relaxed);
    }

    /// The time that it shows.
    pub fn now(&self) -> Duration {
        Duration::from_micros(self.0.load(Ordering::Relaxed))
    }

    fn set(&self, now: Duration) {
        self.0.store(now.as_micros() as u64, Ordering::Relaxed);
    }
}

impl Clock for Hand {
    fn now(&self) -> Duration {
        Self::now(self)
    }
}

impl direct::Hand for Hand {
    fn pass_until(&mut self, until: Duration) {
        self.set(until.max(Self::now(self)));
    }
}

/// A link to a peer that follows a script, step by step. Whatever the script does not expect fails the test. Reads end at
/// their time at once: the clock is a number.
pub struct Scripted {
    clock: Hand,
    /// When the last step happened.
    last: Duration,
    steps: VecDeque<Step>,
    /// The most bytes that one read returns.
    chunk: usize,
    delay: Duration,
    open: bool,
    /// What comes after the script.
    noise: Option<Noise>,
}

/// A peer that has gone mad: it sends random bytes, and valid answers whole, spoilt or at a wrong time.
struct Noise {
    random: Random,
    answers: Vec<Vec<u8>>,
    has_begun: bool,
}

impl Scripted {
    /// A link to a peer that follows the steps.
    pub fn new(steps: impl IntoIterator<Item = Step>) -> Self {
        Self {
            clock: Hand::at(100_000),
            last: Duration::from_secs(100),
            steps: steps.into_iter().collect(),
            chunk: usize::MAX,
            delay: Duration::ZERO,
            open: true,
            noise: None,
        }
    }

    /// The same, with a peer that sends nonsense after the script, when it receives something.
    pub fn then_noise(mut self, seed: u64, answers: Vec<Vec<u8>>) -> Self {
        let random = Random(seed);
        self.noise = Some(Noise {
            random,
            answers,
            has_begun: false,
        });
        self
    }

    /// The same, where bytes come in chunks of this size at most.
    pub fn in_chunks(mut self, chunk: usize) -> Self {
        self.chunk = chunk;
        self
    }

    /// The same, which may delay answers by some milliseconds.
    pub fn delayed(mut self, ms: u64) -> Self {
        self.delay = Duration::from_millis(ms);
        self
    }

    /// The hand of its clock.
    pub fn hand(&self) -> Hand {
        self.clock.clone()
    }

    fn closed(&self) -> Error {
        Error::Disconnected {
            link: self.name().into(),
            cause: "hung up".into(),
        }
    }
}

impl Drop for Scripted {
    /// A script that was not played to its end is also a failure.
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert!(self.steps.is_empty(), "left in the script: {:?}", self.steps);
        }
    }
}

impl Clock for Scripted {
    fn now(&self) -> Duration {
        self.clock.now()
    }
}

impl Link for Scripted {
    fn name(&self) -> &'static str {
        "script"
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        if !self.open {
            return Err(self.closed());
        }
        if until <= self.now() {
            return Ok(0);
        }
        if let Some(Noise {
            random,
            answers,
            has_begun: true,
        }) = &mut self.noise
        {
            let gap = Duration::from_micros(random.below(60_000) as u64);
            let bytes = match random.below(4) {
                0 => random.bytes(buffer.len().min(300)),
                1 => answers[random.below(answers.len())].clone(),
                _ => {
                    let answer = random.below(answers.len());
                    random.mutated(&answers[answer])
                }
            };
            let then = self.clock.now() + gap;
            let count = if then < until { bytes.len().min(buffer.len()) } else { 0 };
            self.clock.set(then.min(until));
            if count == 0 {
                self.clock.set(until);
            }
            buffer[..count].copy_from_slice(&bytes[..count]);
            return Ok(count);
        }
        match self.steps.front_mut() {
            Some(Step::Say(after, bytes)) if self.last + *after < until => {
                let then = self.last + *after;
                let count = bytes.len().min(buffer.len()).min(self.chunk);
                buffer[..count].copy_from_slice(&bytes[..count]);
                bytes.drain(..count);
                if bytes.is_empty() {
                    self.last = then;
                    self.steps.pop_front();
                }
                self.clock.set(self.now().max(then));
                Ok(count)
            }
            Some(Step::HangUp) => {
                self.open = false;
                self.steps.pop_front();
                Err(self.closed())
            }
            _ => {
                self.clock.set(until);
                Ok(0)
            }
        }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let now = self.now();
        match self.steps.front() {
            Some(Step::Say(after, _)) if self.last + *after <= now => {
                let count = self.read(buffer, now + Duration::from_micros(1));
                self.clock.set(now);
                count
            }
            _ if !self.open => Err(self.closed()),
            _ => Ok(0),
        }
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        if !self.open {
            return Err(self.closed());
        }
        if let (true, Some(noise)) = (self.steps.is_empty(), &mut self.noise) {
            noise.has_begun = true;
            return Ok(());
        }
        match self.steps.pop_front() {
            Some(Step::Hear(expected)) => {
                let shown = super::talk::shown;
                assert_eq!(shown(bytes), shown(&expected), "left: {:?}", self.steps);
                self.last = self.now();
                Ok(())
            }
            Some(Step::HangUp) => {
                self.open = false;
                Err(self.closed())
            }
            step => panic!("{:?} was sent where the script has {step:?}", super::talk::shown(bytes)),
        }
    }

    fn delay(&self) -> Duration {
        self.delay
    }

    fn reopen(&mut self) -> Result {
        match self.steps.pop_front() {
            Some(Step::Reopen) => {
                self.open = true;
                self.last = self.now();
                Ok(())
            }
            step => panic!("opened again where the script has {step:?}"),
        }
    }
}

/// A generator of random numbers (`SplitMix64`), for streams of bytes.
pub struct Random(pub u64);

impl Random {
    /// The next number.
    #[expect(clippy::should_implement_trait, reason = "it never ends")]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Random bytes, at most `most`.
    pub fn bytes(&mut self, most: usize) -> Vec<u8> {
        let count = self.below(most + 1);
        (0..count).map(|_| self.next() as u8).collect()
    }

    /// A stream with some bytes changed, left out or doubled.
    pub fn mutated(&mut self, stream: &[u8]) -> Vec<u8> {
        let mut stream = stream.to_vec();
        for _ in 0..=self.below(4) {
            if stream.is_empty() {
                return stream;
            }
            let place = self.below(stream.len());
            match self.below(3) {
                0 => stream[place] = self.next() as u8,
                1 => drop(stream.remove(place)),
                _ => stream.insert(place, stream[place]),
            }
        }
        stream
    }
}
