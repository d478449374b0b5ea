//! Numbers of a world that are drawn within ranges or from lists, for worlds of which each trial takes one.

use crate::parameter::{Datum, Field};

/// Most drawn worlds.
pub(super) const GREATEST_DRAWN: u32 = 1000;

/// What differs between worlds. Numbers are known by their keys in an experiment's file; a key with `[]` stands for each element of
/// a list, with draws of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Varied {
    /// Number of drawn worlds, 1 to 1000; `None`: 100.
    pub count: Option<u32>,
    /// Seed of the draws; `None`: 0.
    pub seed: Option<u64>,
    /// Numbers drawn uniformly from a range: `[least, greatest]`, and `[[least, greatest], [least, greatest]]` for pairs of numbers.
    pub vary: ByKey,
    /// Numbers chosen from a list of values, all equally likely.
    pub choose: ByKey,
}

/// Values by key, in the order of the keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ByKey(pub Vec<(String, Datum)>);

impl Varied {
    /// The keys of drawn numbers, each with the table that names it.
    pub fn keys(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let varied = self.vary.0.iter().map(|(key, _)| ("worlds.vary", key.as_str()));
        varied.chain(self.choose.0.iter().map(|(key, _)| ("worlds.choose", key.as_str())))
    }

    /// Without the numbers whose keys are dropped.
    pub fn retain(&mut self, is_kept: impl Fn(&str) -> bool) {
        for own in [&mut self.vary, &mut self.choose] {
            own.0.retain(|(key, _)| is_kept(key));
        }
        if self.vary.0.is_empty() && self.choose.0.is_empty() {
            *self = Self::default();
        }
    }
}

impl Field for ByKey {
    fn get(&self) -> Option<Datum> {
        (!self.0.is_empty()).then(|| Datum::Table(self.0.clone()))
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let Datum::Table(table) = datum else { return false };
        if table.iter().any(|(_, datum)| !matches!(datum, Datum::List(_))) {
            return false;
        }
        self.0.clone_from(table);
        self.0.sort_by(|a, b| a.0.cmp(&b.0));
        true
    }

    fn kind(&self) -> &'static str {
        "a table of keys with lists of numbers"
    }
}

impl Varied {
    pub(super) fn is_empty(&self) -> bool {
        self.vary.0.is_empty() && self.choose.0.is_empty()
    }
}
