//! The guard's values, each described by a row.

use std::time::Duration;

/// A value of the guard: its key on the command line, what is allowed, and why.
pub struct Row {
    /// Its name.
    pub key: &'static str,
    /// Unit; empty for a number.
    pub unit: &'static str,
    /// The default.
    pub default: f64,
    /// Minimum and maximum.
    pub range: (f64, f64),
    /// What it does.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test holds the documents to it"))]
    pub(crate) meaning: &'static str,
    /// Where default and range are from.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test holds the documents to it"))]
    pub(crate) source: &'static str,
    field: fn(&mut Values) -> &mut f64,
}

/// All values, in the order of the documents.
pub const ROWS: [Row; 11] = [
    Row {
        key: "expiry_ms",
        unit: "ms",
        default: 300.0,
        range: (100.0, 500.0),
        meaning: "How long a command remains valid. The wheels stop unless a newer one arrives",
        source: "ours; Crazyflie's and ROS 2's limits are 500 ms, Kobuki's is 600 ms",
        field: |values| &mut values.expiry_ms,
    },
    Row {
        key: "silence_ms",
        unit: "ms",
        default: 2000.0,
        range: (500.0, 10_000.0),
        meaning: "After this long without a command, a `resume` is also needed",
        source: "Crazyflie locks after 2000 ms",
        field: |values| &mut values.silence_ms,
    },
    Row {
        key: "link_ms",
        unit: "ms",
        default: 250.0,
        range: (100.0, 400.0),
        meaning: "The wheels stop when the robot has not answered for this long",
        source: "ours: twice the longest exchange of a Khepera at 9600 baud, 120 ms",
        field: |values| &mut values.link_ms,
    },
    Row {
        key: "unconfirmed_ms",
        unit: "ms",
        default: 400.0,
        range: (300.0, 480.0),
        meaning: "\"Cannot stop\" is reported when a stop has gone unconfirmed, or the robot has not answered, for this long",
        source: "ours: it must be reported within 500 ms",
        field: |values| &mut values.unconfirmed_ms,
    },
    Row {
        key: "speed_mm_s",
        unit: "mm/s",
        default: 200.0,
        range: (1.0, 1100.0),
        meaning: "Maximum speed of a wheel, unless the robot's is lower. Both wheels slow down alike",
        source: "ours; a Khepera's maximum is 1041 mm/s",
        field: |values| &mut values.speed_mm_s,
    },
    Row {
        key: "acceleration_mm_s2",
        unit: "mm/s^2",
        default: 400.0,
        range: (50.0, 10_000.0),
        meaning: "Maximum acceleration of a wheel, commanded every 20 ms. It may slow down at once",
        source: "ours: 200 mm/s after 0.5 s",
        field: |values| &mut values.acceleration_mm_s2,
    },
    Row {
        key: "errors",
        unit: "",
        default: 3.0,
        range: (1.0, 10.0),
        meaning: "Number of consecutive invalid messages that stop the wheels",
        source: "ours",
        field: |values| &mut values.errors,
    },
    Row {
        key: "lifted",
        unit: "",
        default: 1.0,
        range: (0.0, 1.0),
        meaning: "1 stops a robot that senses that it is lifted. 0 is for a Thymio II on a black floor, which looks the same",
        source: "ours",
        field: |values| &mut values.lifted,
    },
    Row {
        key: "fuse",
        unit: "",
        default: 1.0,
        range: (0.0, 1.0),
        meaning: "1 gives a Thymio II a program that stops its wheels when no command has come for 0.5 s by its clock. 0 is for simulators that run faster",
        source: "ours",
        field: |values| &mut values.fuse,
    },
    Row {
        key: "give_up_s",
        unit: "s",
        default: 60.0,
        range: (5.0, 3600.0),
        meaning: "How long the guard tries to stop a robot that does not confirm it, before it ends with exit code 4",
        source: "ours",
        field: |values| &mut values.give_up_s,
    },
    Row {
        key: "realtime",
        unit: "",
        default: 1.0,
        range: (0.0, 1.0),
        meaning: "1 gives the guard, and the thread that drives while the wheels may turn, real-time priority where the system allows it. 0 leaves their priority unchanged",
        source: "ours",
        field: |values| &mut values.realtime,
    },
];

/// The values of one guard.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    expiry_ms: f64,
    silence_ms: f64,
    link_ms: f64,
    unconfirmed_ms: f64,
    /// Maximum speed of a wheel, mm/s.
    pub speed_mm_s: f64,
    /// Maximum change of a wheel's speed, mm/s^2.
    pub acceleration_mm_s2: f64,
    errors: f64,
    lifted: f64,
    fuse: f64,
    give_up_s: f64,
    realtime: f64,
}

impl Default for Values {
    fn default() -> Self {
        let mut values = Self {
            expiry_ms: 0.0,
            silence_ms: 0.0,
            link_ms: 0.0,
            unconfirmed_ms: 0.0,
            speed_mm_s: 0.0,
            acceleration_mm_s2: 0.0,
            errors: 0.0,
            lifted: 0.0,
            fuse: 0.0,
            give_up_s: 0.0,
            realtime: 0.0,
        };
        for row in &ROWS {
            *(row.field)(&mut values) = row.default;
        }
        values
    }
}

impl Values {
    /// The defaults with some values changed, each written `KEY=VALUE`.
    ///
    /// # Errors
    /// The first setting that is not valid, with what is allowed.
    pub fn of(settings: &[String]) -> Result<Self, String> {
        let mut values = Self::default();
        for setting in settings {
            values.set(setting)?;
        }
        Ok(values)
    }

    fn set(&mut self, setting: &str) -> Result<(), String> {
        let (key, text) = setting
            .split_once('=')
            .ok_or_else(|| format!("guard `{setting}`: is no setting; allowed: KEY=VALUE, such as expiry_ms=200"))?;
        let row = ROWS.iter().find(|row| row.key == key).ok_or_else(|| {
            let keys = ROWS.map(|row| row.key).join(", ");
            format!("guard {key}: is no value of the guard; allowed: {keys}")
        })?;
        let (least, greatest) = row.range;
        let value = text.parse().ok().filter(|value| (least..=greatest).contains(value));
        *(row.field)(self) = value.ok_or_else(|| {
            let allowed = format!("{least} to {greatest} {}", row.unit);
            format!("guard {key}: `{text}` is out of range; allowed: {}", allowed.trim_end())
        })?;
        Ok(())
    }

    /// How long a command counts.
    pub fn expiry(&self) -> Duration {
        milliseconds(self.expiry_ms)
    }

    /// How long the program may send no command before a resume is needed.
    pub fn silence(&self) -> Duration {
        milliseconds(self.silence_ms)
    }

    /// How long the robot may answer nothing.
    pub fn link(&self) -> Duration {
        milliseconds(self.link_ms)
    }

    /// How long a stop may be unconfirmed.
    pub(crate) fn unconfirmed(&self) -> Duration {
        milliseconds(self.unconfirmed_ms)
    }

    /// How many messages in a row may make no sense, this one included.
    pub fn errors(&self) -> u32 {
        self.errors as u32
    }

    /// Whether a lifted robot is stopped.
    pub fn lifted(&self) -> bool {
        self.lifted > 0.5
    }

    /// Whether a robot that can gets a program that stops it.
    pub(crate) fn fuse(&self) -> bool {
        self.fuse > 0.5
    }

    /// How long to try to stop before giving up.
    pub(crate) fn give_up(&self) -> Duration {
        milliseconds(1000.0 * self.give_up_s)
    }

    /// Whether real-time priority is wanted.
    pub(crate) fn realtime(&self) -> bool {
        self.realtime > 0.5
    }
}

/// A time from the table, which has no value that could not be a time.
fn milliseconds(value: f64) -> Duration {
    Duration::from_micros((1000.0 * value) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_value_is_set_within_its_range_and_not_beyond() {
        for row in &ROWS {
            let set = |value: f64| Values::of(&[format!("{}={value}", row.key)]);
            let (least, greatest) = row.range;
            assert!((least..=greatest).contains(&row.default), "{}", row.key);
            assert_eq!(set(row.default).unwrap(), Values::default());
            for value in [least, greatest] {
                assert_eq!(*(row.field)(&mut set(value).unwrap()), value, "{}", row.key);
            }
            for value in [least - 1.0, greatest + 1.0, f64::NAN, f64::INFINITY] {
                let refusal = set(value).unwrap_err();
                assert!(refusal.contains(row.key), "{refusal}");
                assert!(
                    refusal.contains(&format!("allowed: {least} to {greatest}")),
                    "{refusal}"
                );
            }
        }
    }

    #[test]
    fn no_two_rows_have_the_same_key_or_field() {
        for (at, row) in ROWS.iter().enumerate() {
            let mut values = Values::default();
            *(row.field)(&mut values) = -1.0;
            for (other, another) in ROWS.iter().enumerate() {
                assert_eq!(*(another.field)(&mut values) == -1.0, at == other);
                assert_eq!(another.key == row.key, at == other);
            }
        }
    }

    #[test]
    fn what_is_no_setting_is_refused() {
        for (setting, words) in [
            ("expiry_ms", "KEY=VALUE"),
            (
                "expiry=200",
                "guard expiry: is no value of the guard; allowed: expiry_ms, silence_ms",
            ),
            (
                "expiry_ms=",
                "guard expiry_ms: `` is out of range; allowed: 100 to 500 ms",
            ),
            ("errors=x", "guard errors: `x` is out of range; allowed: 1 to 10"),
        ] {
            let refusal = Values::of(&[setting.to_owned()]).unwrap_err();
            assert!(refusal.contains(words), "{refusal}");
        }
    }

    /// The documents' table has a row for each value.
    #[test]
    fn the_documents_have_every_value() {
        let page = include_str!("../../../../docs/robots-on-the-wire.md");
        for row in &ROWS {
            let (least, greatest) = row.range;
            let value = |value: f64| format!("{value} {}", row.unit).trim_end().to_owned();
            let line = format!(
                "| `{}` | {} | {least} to {} | {} | {} |",
                row.key,
                value(row.default),
                value(greatest),
                row.meaning,
                row.source
            );
            assert!(page.contains(&line), "missing:\n{line}");
        }
    }
}
