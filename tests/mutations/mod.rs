//! Texts as nobody would write them: words, lines or characters of a text deleted, doubled, swapped, replaced or repeated.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs};

use oneiro::random::pcg4d;

/// Most copies of a repeated piece, and most bytes of them; a text that is longer is not changed any more.
const MANY: u32 = 3_000;
const LONG: usize = 100_000;

/// Characters that few texts have a use for.
const CHARACTERS: [&str; 6] = ["\0", "\r", "\u{e9}", "\u{202e}", "\u{feff}", "\u{1f916}"];

/// Words, numbers, blanks and single signs.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = if is_word(first) {
            rest.find(|c: char| !is_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        tokens.push(&rest[..end]);
        rest = &rest[end..];
    }
    tokens
}

/// A text with one to three changes, or with 200; `odd` are pieces that it has no use for.
pub(crate) fn mutant(text: &str, odd: &[&str], seed: u32) -> String {
    let mut text = text.to_owned();
    let changes = if seed % 16 == 15 { 200 } else { 1 + seed % 3 };
    for change in 0..changes {
        let [[unit, kind, a, b], [many, ..]] = [[1, 2], [3, 4]].map(|[c, d]| pcg4d([seed, change, c, d]));
        let (mut pieces, odd) = match unit % 8 {
            0 => (text.split_inclusive('\n').collect(), odd),
            1 => (text.split("").collect(), &CHARACTERS[..]),
            _ => (tokens(&text), odd),
        };
        let places: Vec<usize> = (0..pieces.len()).filter(|at| !pieces[*at].trim().is_empty()).collect();
        if places.is_empty() || text.len() > LONG {
            break;
        }
        let [a, other] = [a, b].map(|word| places[word as usize % places.len()]);
        let repeated = pieces[a].repeat(((many % MANY) as usize).min(LONG / pieces[a].len()));
        match kind % 16 {
            0..3 => _ = pieces.remove(a),
            3..6 => pieces.insert(a, pieces[a]),
            6..9 => pieces.swap(a, other),
            9..11 => pieces[a] = pieces[other],
            11..14 => pieces[a] = odd[b as usize % odd.len()],
            14 => pieces.truncate(a),
            _ => pieces[a] = &repeated,
        }
        text = pieces.concat();
    }
    text
}

/// Runs a test, named with its modules and its crate, in a process of its own, since it measures what a process takes. Returns whether
/// this is that process.
pub(crate) fn alone(test: &str) -> bool {
    const ALONE: &str = "ONEIRO_TEST_ALONE";
    if env::var_os(ALONE).is_some() {
        return true;
    }
    let (_, test) = test.split_once("::").unwrap();
    let run = Command::new(env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture", "--include-ignored"])
        .env(ALONE, "1")
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    let output = String::from_utf8_lossy(&run.stdout);
    // A name that no test has is no failure there.
    assert!(
        output.contains("test result: ok. 1 passed"),
        "{test}: {output}{}",
        run.status
    );
    false
}

/// The most memory that this process has had, KB; 0 where the system doesn't tell.
pub(crate) fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok())
        .unwrap_or(0)
}

/// How long something has taken: the processor time that this process or this thread has had since, where the system tells,
/// because on a busy machine minutes of the clock may be seconds of work; otherwise by the clock.
pub(crate) struct Spent {
    whose: &'static str,
    begin: Instant,
    before: Option<Duration>,
}

impl Spent {
    /// By this process with all of its threads, `self`, or by the calling thread, `thread-self`.
    pub(crate) fn by(whose: &'static str) -> Self {
        Self {
            whose,
            begin: Instant::now(),
            before: processor_time(whose),
        }
    }

    /// The time since then.
    pub(crate) fn time(&self) -> Duration {
        let worked = self.before.zip(processor_time(self.whose));
        worked.map_or_else(|| self.begin.elapsed(), |(before, now)| now.saturating_sub(before))
    }
}

/// Processor time of a process or a thread, in its own code and in the system's.
fn processor_time(whose: &str) -> Option<Duration> {
    let stat = fs::read_to_string(format!("/proc/{whose}/stat")).ok()?;
    // Its name, in brackets, may have spaces; after it the 12th and the 13th field are hundredths of a second.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = fields.split_whitespace().skip(11).take(2).map(str::parse::<u64>);
    let sum = ticks.collect::<Result<Vec<_>, _>>().ok()?.into_iter().sum::<u64>();
    Some(Duration::from_millis(10 * sum))
}

/// Calls for each seed from 0 on: as many as `seeds`, or where `ONEIRO_LONG` is set for two minutes of a
/// processor.
pub(crate) fn for_seeds(seeds: u64, call: impl FnMut(u64)) {
    for_seeds_within(Duration::from_mins(2), seeds, call);
}

/// The same, for `long` of a processor where `ONEIRO_LONG` is set.
pub(crate) fn for_seeds_within(long: Duration, seeds: u64, mut call: impl FnMut(u64)) {
    /// Says which seed it was.
    struct Seed(u64);

    impl Drop for Seed {
        fn drop(&mut self) {
            if std::thread::panicking() {
                eprintln!("seed {}", self.0);
            }
        }
    }

    let (spent, is_long) = (Spent::by("thread-self"), env::var_os("ONEIRO_LONG").is_some());
    let is_over = |seed: u64| seed >= seeds && (!is_long || spent.time() >= long);
    let mut count = 0;
    for seed in (0..).take_while(|seed| !is_over(*seed)) {
        let seed = Seed(seed);
        call(seed.0);
        count += 1;
    }
    if is_long {
        let name = std::thread::current().name().unwrap_or_default().to_owned();
        eprintln!("{name}: {count} seeds in {:.1?} of a processor", spent.time());
    }
}
