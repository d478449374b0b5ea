//! A file of commands: on each line seconds, and the speeds of the left and the right wheel.

use std::path::Path;
use std::time::Duration;

use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;

/// Speeds one after the other.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Script(Vec<(Duration, [f64; 2])>);

impl Script {
    /// The longest time on a line, s.
    const LONGEST: f64 = 3600.0;
    /// The greatest speed, mm/s. The guard's limit may be lower.
    const FASTEST: f64 = 1100.0;

    /// Reads a file.
    ///
    /// # Errors
    /// It can't be read, or has a line that is not valid.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = files::text(path)?;
        Self::parse(&text).map_err(|problem| Failure::input(format_args!("{}: {problem}", path.display())))
    }

    fn parse(text: &str) -> std::result::Result<Self, String> {
        let lines = text.lines().zip(1..).map(|(line, number)| {
            let line = line.split('#').next().unwrap_or_default().trim();
            (line, number)
        });
        let lines = lines.filter(|(line, _)| !line.is_empty());
        let steps: std::result::Result<Vec<_>, String> = lines
            .map(|(line, number)| {
                step(line).ok_or_else(|| {
                    format!(
                        "line {number}: \"{line}\" is no command; allowed: SECONDS LEFT RIGHT, such as 1.5 50 -50, with \
                         more than 0 and up to {} s, and -{fastest} to {fastest} mm/s",
                        Self::LONGEST,
                        fastest = Self::FASTEST
                    )
                })
            })
            .collect();
        match steps? {
            steps if steps.is_empty() => Err("has no commands; allowed: lines of SECONDS LEFT RIGHT".into()),
            steps => Ok(Self(steps)),
        }
    }

    /// The speeds at a time since the beginning, mm/s; none after the end.
    pub(super) fn speeds(&self, mut time: Duration) -> Option<[f64; 2]> {
        for (duration, speeds) in &self.0 {
            match time.checked_sub(*duration) {
                Some(rest) => time = rest,
                None => return Some(*speeds),
            }
        }
        None
    }
}

fn step(line: &str) -> Option<(Duration, [f64; 2])> {
    let fields: Option<Vec<f64>> = line.split_whitespace().map(|field| field.parse().ok()).collect();
    let [seconds, left, right] = fields?[..] else {
        return None;
    };
    let valid =
        seconds > 0.0 && seconds <= Script::LONGEST && [left, right].iter().all(|speed| speed.abs() <= Script::FASTEST);
    valid.then(|| (Duration::from_secs_f64(seconds), [left, right]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_follow_one_another() {
        let script = Script::parse("# a curve\n1.5 50 -50\n\n 0.5\t20 30 # back\r\n").unwrap();
        let at = |ms| script.speeds(Duration::from_millis(ms));
        assert_eq!(at(0), Some([50.0, -50.0]));
        assert_eq!(at(1499), Some([50.0, -50.0]));
        assert_eq!(at(1500), Some([20.0, 30.0]));
        assert_eq!(at(2000), None);
    }

    #[test]
    fn what_is_no_command_is_refused_by_its_line() {
        for line in [
            "1 2",
            "1 2 3 4",
            "0 1 1",
            "-1 1 1",
            "3601 1 1",
            "1 1101 0",
            "1 0 -1101",
            "1 NaN 0",
            "inf 1 1",
            "one 1 1",
        ] {
            let refusal = Script::parse(&format!("1 0 0\n{line}")).unwrap_err();
            assert!(refusal.starts_with("line 2: "), "{refusal}");
            assert!(refusal.contains("allowed: SECONDS LEFT RIGHT"), "{refusal}");
        }
        assert!(Script::parse("# nothing\n").unwrap_err().contains("no commands"));
    }

    /// A file that is accepted ends, and has no speeds beyond the limits.
    #[test]
    fn a_file_may_have_anything() {
        use crate::mutations::for_seeds;
        use oneiro_robots::script::Random;

        let known = "# a curve\n1.5 50 -50\n\n 0.5\t1100 30 # back\r\n3600 0 -1e3\n";
        let mut accepted = 0;
        for_seeds(5000, |seed| {
            let mut random = Random(seed);
            let bytes = match random.below(8) {
                0 => random.bytes(100),
                _ => random.mutated(known.as_bytes()),
            };
            let text = String::from_utf8_lossy(&bytes);
            let Ok(script) = Script::parse(&text) else { return };
            accepted += 1;
            let (mut time, mut steps) = (Duration::ZERO, 0);
            while let Some(speeds) = script.speeds(time) {
                assert!(speeds.iter().all(|speed| speed.abs() <= Script::FASTEST), "{text:?}");
                time += Duration::from_mins(1);
                steps += 1;
                assert!(steps < 10_000, "{text:?}");
            }
        });
        assert!(accepted > 100, "{accepted}");
    }
}
