//! Descriptions of values. A row says everything about one value of a specification: its key in an experiment's file,
//! its unit, the allowed values, the source of its default, its meaning, and the field that holds it. Validation,
//! reading and writing of experiments, and the reference page all derive from these rows.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// A value of a specification `T`.
#[derive(Debug)]
pub struct Parameter<T> {
    /// Key in an experiment's file, such as `noise.motor`; with `[]` for every element of a list, such as
    /// `arena.walls[].class`.
    pub key: &'static str,
    /// Unit; empty for words, counts and shares.
    pub unit: &'static str,
    /// Allowed values.
    pub allowed: Allowed,
    /// Source of the default: a paper, another simulator, or our own choice.
    pub source: &'static str,
    /// Meaning, in one line.
    pub about: &'static str,
    /// Selects the field that holds it, if this specification has one.
    pub field: Select<T>,
}

/// Selects the field of a specification that holds a value; the number is the index of a list's element.
pub type Select<T> = for<'a> fn(&'a mut T, usize) -> Option<&'a mut dyn Field>;

/// Allowed values, beyond the type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// Anything of the field's type.
    Any,
    /// Text; the rule is described in words.
    Text(&'static str),
    /// Whole numbers in a range, ends included.
    Whole(u64, u64),
    /// Whole numbers from a minimum to the value of another key.
    WholeUpTo(u64, &'static str),
    /// Numbers in a range, ends included.
    Number(f64, f64),
    /// Numbers from a minimum to a multiple of the value of another key.
    NumberUpTo(f64, f64, &'static str),
}

/// A value, independent of its field's type.
#[derive(Clone, Debug, PartialEq)]
pub enum Datum {
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i128),
    /// A single-precision number, as in kernels.
    Single(f32),
    /// A double-precision number.
    Double(f64),
    /// A word or a text.
    Word(String),
    /// Several values.
    List(Vec<Datum>),
    /// Values by name.
    Table(Vec<(String, Datum)>),
}

/// A field that can hold a value.
pub trait Field {
    /// Returns the value, if it is set.
    fn get(&self) -> Option<Datum>;

    /// Sets the value; returns false if it has the wrong type.
    fn set(&mut self, datum: &Datum) -> bool;

    /// Name of the type.
    fn kind(&self) -> &'static str;

    /// Words to choose from with their meanings; empty if the field isn't a choice.
    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        Vec::new()
    }

    /// Resizes a list, whose elements are then filled by their own rows; false if the field isn't such a list.
    fn resize(&mut self, _: usize) -> bool {
        false
    }
}

/// Each word of a choice, its value, and its meaning.
pub type Choices<C> = &'static [(&'static str, C, &'static str)];

/// A choice between words.
pub trait Choice: Clone + 'static {
    /// Words in the order in which they are listed.
    const CHOICES: Choices<Self>;

    /// Whether it is written in an experiment with all defaults.
    fn is_written(&self) -> bool {
        true
    }

    /// Word for the value.
    fn word(&self) -> &'static str {
        let kind = std::mem::discriminant(self);
        let found = Self::CHOICES
            .iter()
            .find(|(_, value, _)| std::mem::discriminant(value) == kind);
        found.map_or("", |(word, ..)| word)
    }
}

impl<C: Choice> Field for C {
    fn get(&self) -> Option<Datum> {
        self.is_written().then(|| Datum::Word(self.word().into()))
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let found = Self::CHOICES
            .iter()
            .find(|(word, ..)| matches!(datum, Datum::Word(other) if other == word));
        if let Some((_, value, _)) = found {
            *self = value.clone();
        }
        found.is_some()
    }

    fn kind(&self) -> &'static str {
        "one of the words"
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        Self::CHOICES.iter().map(|(word, _, about)| (*word, *about)).collect()
    }
}

/// How alike two names are, 0 to 1. Keys with dots are also compared by their last words.
pub fn likeness(name: &str, written: &str) -> f64 {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let whole = strsim::normalized_damerau_levenshtein(name, written);
    whole.max(0.99 * strsim::normalized_damerau_levenshtein(&last(name), &last(written)))
}

/// The name most like the written one: a typo, or the same key in another table. `None` if none is much like it, or the
/// written one is longer than any name.
pub fn nearest<'a>(names: impl Iterator<Item = &'a str>, written: &str) -> Option<&'a str> {
    const LONGEST: usize = 200;
    // One mistake in three letters is less than 0.7.
    let alike = if written.len() > 3 { 0.7 } else { 0.66 };
    let best = names
        .filter(|_| written.len() <= LONGEST)
        .map(|name| (likeness(name, written), name))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(likeness, _)| *likeness >= alike).map(|(_, name)| name)
}

/// Implements [`Field`] for a type: its name, the value from data, and data from the value.
macro_rules! field {
    ($type:ty, $kind:literal, $from:expr, $to:expr) => {
        impl Field for $type {
            fn get(&self) -> Option<Datum> {
                let to: fn(&$type) -> Datum = $to;
                Some(to(self))
            }

            fn set(&mut self, datum: &Datum) -> bool {
                let from: fn(&Datum) -> Option<$type> = $from;
                let value = from(datum);
                let is_set = value.is_some();
                if let Some(value) = value {
                    *self = value;
                }
                is_set
            }

            fn kind(&self) -> &'static str {
                $kind
            }
        }
    };
}

impl Datum {
    pub(crate) fn number(&self) -> Option<f64> {
        match *self {
            Self::Whole(number) => Some(number as f64),
            Self::Single(number) => Some(f64::from(number)),
            Self::Double(number) => Some(number),
            _ => None,
        }
    }

    pub(crate) fn whole<T: TryFrom<i128>>(&self) -> Option<T> {
        match *self {
            Self::Whole(number) => number.try_into().ok(),
            _ => None,
        }
    }

    fn pair(&self) -> Option<[f64; 2]> {
        match self {
            Self::List(list) => match &list[..] {
                [first, second] => Some([first.number()?, second.number()?]),
                _ => None,
            },
            _ => None,
        }
    }

    fn word(&self) -> Option<&String> {
        match self {
            Self::Word(word) => Some(word),
            _ => None,
        }
    }
}

field!(
    bool,
    "true or false",
    |datum| matches!(datum, Datum::Flag(_)).then(|| *datum == Datum::Flag(true)),
    |value| { Datum::Flag(*value) }
);
field!(u32, "a whole number", Datum::whole, |value| Datum::Whole(
    (*value).into()
));
field!(u64, "a whole number", Datum::whole, |value| Datum::Whole(
    (*value).into()
));
field!(
    f32,
    "a number",
    |datum| datum.number().map(|number| number as f32),
    |value| { Datum::Single(*value) }
);
field!(f64, "a number", Datum::number, |value| Datum::Double(*value));
field!(String, "text", |datum| datum.word().cloned(), |value| Datum::Word(
    value.clone()
));
field!(
    [f32; 2],
    "two numbers",
    |datum| Some(datum.pair()?.map(|number| number as f32)),
    |value| { Datum::List(value.map(Datum::Single).into()) }
);
field!([f64; 2], "two numbers", Datum::pair, |value| Datum::List(
    value.map(Datum::Double).into()
));
field!(
    (f32, f32),
    "two numbers",
    |datum| Some(datum.pair()?.map(|number| number as f32).into()),
    |value| { Datum::List(vec![Datum::Single(value.0), Datum::Single(value.1)]) }
);

impl<F: Field + Default> Field for Option<F> {
    fn get(&self) -> Option<Datum> {
        self.as_ref().and_then(Field::get)
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let mut value = F::default();
        let is_set = value.set(datum);
        if is_set {
            *self = Some(value);
        }
        is_set
    }

    fn kind(&self) -> &'static str {
        F::default().kind()
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        F::default().choices()
    }
}

/// Implements [`Field`] for values by name; an empty map isn't written.
macro_rules! field_by_name {
    ($type:ty, $kind:literal, $from:expr, $to:expr) => {
        impl Field for BTreeMap<String, $type> {
            fn get(&self) -> Option<Datum> {
                let to: fn(&$type) -> Datum = $to;
                let values = self.iter().map(|(name, value)| (name.clone(), to(value)));
                (!self.is_empty()).then(|| Datum::Table(values.collect()))
            }

            fn set(&mut self, datum: &Datum) -> bool {
                let Datum::Table(table) = datum else {
                    return false;
                };
                let from: fn(&Datum) -> Option<$type> = $from;
                let values = table
                    .iter()
                    .map(|(name, value)| Some((name.clone(), from(value)?)));
                let values: Option<Self> = values.collect();
                let is_set = values.is_some();
                *self = values.unwrap_or_default();
                is_set
            }

            fn kind(&self) -> &'static str {
                $kind
            }
        }
    };
}

field_by_name!(String, "a table of texts", |datum| datum.word().cloned(), |text| {
    Datum::Word(text.clone())
});
field_by_name!(f64, "a table of numbers", Datum::number, |number| Datum::Double(
    *number
));

/// Implements [`Field`] for a struct of one list of pairs of numbers.
macro_rules! field_of_pairs {
    ($type:ty) => {
        impl $crate::parameter::Field for $type {
            fn get(&self) -> Option<$crate::parameter::Datum> {
                let pairs = self.0.iter().map($crate::parameter::Field::get);
                Some($crate::parameter::Datum::List(pairs.flatten().collect()))
            }

            fn set(&mut self, datum: &$crate::parameter::Datum) -> bool {
                let $crate::parameter::Datum::List(pairs) = datum else {
                    return false;
                };
                self.0 = vec![[0.0; 2]; pairs.len()];
                self.0
                    .iter_mut()
                    .zip(pairs)
                    .all(|(pair_of_values, pair)| pair_of_values.set(pair))
            }

            fn kind(&self) -> &'static str {
                "a list of pairs of numbers"
            }
        }
    };
}
pub(crate) use field_of_pairs;

/// A list whose elements have rows.
impl<T: Default> Field for Vec<T> {
    fn get(&self) -> Option<Datum> {
        None
    }

    fn set(&mut self, _: &Datum) -> bool {
        false
    }

    fn kind(&self) -> &'static str {
        "a list of tables"
    }

    fn resize(&mut self, count: usize) -> bool {
        self.clear();
        self.resize_with(count, T::default);
        true
    }
}

impl Display for Datum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Single(number) => write!(f, "{number}"),
            // With its point, as a file has it.
            Self::Double(number) => write!(f, "{number:?}"),
            Self::Word(word) => write!(f, "{word:?}"),
            Self::List(list) => {
                let list: Vec<String> = list.iter().map(ToString::to_string).collect();
                write!(f, "[{}]", list.join(", "))
            }
            Self::Table(_) => write!(f, "a table"),
        }
    }
}

/// Numbers closer to zero than this (about 1e-6), except zero itself, are refused: they would lead to subnormals in
/// kernels.
pub(crate) const LEAST: f32 = 1.0 / (1 << 20) as f32;

impl Allowed {
    /// Checks a value; `other` returns the values of other keys.
    ///
    /// # Errors
    /// The value and the allowed values.
    pub fn check(self, datum: &Datum, other: impl Fn(&str) -> Option<Datum> + Copy) -> Result<(), String> {
        if let Datum::List(list) = datum {
            return list.iter().try_for_each(|datum| self.check(datum, other));
        }
        if let Datum::Single(number) = *datum
            && number != 0.0
            && number.abs() < LEAST
        {
            return Err(format!("is {number:e}; allowed: 0, or at least {LEAST:e} in size"));
        }
        let is_allowed = match (self.bounded(other), datum) {
            (Self::Whole(least, greatest), Datum::Whole(number)) => {
                (i128::from(least)..=i128::from(greatest)).contains(number)
            }
            (Self::Number(least, greatest), Datum::Single(number)) => (least as f32..=greatest as f32).contains(number),
            (Self::Number(least, greatest), Datum::Double(number)) => (least..=greatest).contains(number),
            _ => true,
        };
        if is_allowed {
            return Ok(());
        }
        Err(format!("is {datum}; allowed: {}", self.bounded(other)))
    }

    /// The same rule with the value of the key that it depends on filled in.
    fn bounded(self, other: impl Fn(&str) -> Option<Datum>) -> Self {
        match self {
            Self::WholeUpTo(least, key) => {
                let greatest = other(key).and_then(|other| other.whole());
                Self::Whole(least, greatest.unwrap_or(u64::MAX))
            }
            Self::NumberUpTo(least, factor, key) => {
                let greatest = other(key).and_then(|other| other.to_string().parse().ok());
                Self::Number(least, factor * greatest.unwrap_or(f64::MAX))
            }
            limits => limits,
        }
    }
}

impl Display for Allowed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Any => Ok(()),
            Self::Text(words) => write!(f, "{words}"),
            Self::Whole(least, greatest) => write!(f, "{least} to {greatest}"),
            Self::WholeUpTo(least, key) => write!(f, "{least} to {key}"),
            Self::Number(least, greatest) => write!(f, "{least} to {greatest}"),
            Self::NumberUpTo(least, 1.0, key) => write!(f, "{least} to {key}"),
            Self::NumberUpTo(least, factor, key) => write!(f, "{least} to {factor} {key}"),
        }
    }
}

/// Makes a row; the arguments are in the order of a table's columns.
pub const fn row<T>(
    key: &'static str,
    unit: &'static str,
    allowed: Allowed,
    source: &'static str,
    about: &'static str,
    field: Select<T>,
) -> Parameter<T> {
    Parameter {
        key,
        unit,
        allowed,
        source,
        about,
        field,
    }
}

impl<T> Parameter<T> {
    /// Number of values of this row in a specification: one, or the length of a list; 0 if it has no such value.
    pub fn count(&self, specification: &mut T) -> usize {
        let most = if self.key.contains("[]") { usize::MAX } else { 1 };
        let is_none = |&index: &usize| (self.field)(specification, index).is_none();
        (0..most).find(is_none).unwrap_or(most)
    }

    /// Key of one of the values.
    pub fn name(&self, index: usize) -> String {
        self.key.replacen("[]", &format!("[{index}]"), 1)
    }
}

/// An error for a value that isn't allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {problem}")]
pub struct Invalid {
    /// Path of the value, such as `noise.sensor` or `arena.walls[3].from`.
    pub field: String,
    /// The value and the allowed values.
    pub problem: String,
}

impl Invalid {
    pub(crate) fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self {
            field: field.into(),
            problem: problem.into(),
        }
    }

    /// The same with the key of the table around the value.
    pub(crate) fn within(self, table: &str) -> Self {
        let dot = if self.field.is_empty() { "" } else { "." };
        Self::new(format!("{table}{dot}{}", self.field), self.problem)
    }
}

/// Checks the number of a list's elements.
pub(crate) fn length(field: impl Into<String>, count: usize, greatest: usize) -> Result<(), Invalid> {
    if count <= greatest {
        return Ok(());
    }
    let problem = format!("has {count} elements; allowed: up to {greatest}");
    Err(Invalid::new(field, problem))
}

/// Refuses values that another value rules out. Each has its key, whether it is given, and whether it is allowed.
pub(crate) fn only_where(other: impl Display, values: &[(&str, bool, bool)]) -> Result<(), Invalid> {
    match values.iter().find(|(_, is_given, is_allowed)| *is_given && !is_allowed) {
        None => Ok(()),
        Some((key, ..)) => Err(Invalid::new(*key, format!("is given; allowed: not with {other}"))),
    }
}

/// Whether a name has letters from a to z, digits and _ only, a letter first.
pub(crate) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

/// Checks a whole number that has no row.
pub(crate) fn integer(field: &str, value: u32, allowed: RangeInclusive<u32>) -> Result<(), Invalid> {
    if allowed.contains(&value) {
        return Ok(());
    }
    Err(Invalid::new(
        field,
        format!("is {value}; allowed: {} to {}", allowed.start(), allowed.end()),
    ))
}

/// Checks a number; the field's name is only formatted for the message.
pub(crate) fn number(field: impl Display, value: f32, allowed: RangeInclusive<f32>) -> Result<(), Invalid> {
    if !allowed.contains(&value) {
        let problem = format!("is {value}; allowed: {} to {}", allowed.start(), allowed.end());
        return Err(Invalid::new(field.to_string(), problem));
    }
    allowed_number(field, value, Allowed::Any)
}

/// Checks the rules for all numbers: finite, and not too close to zero.
pub(crate) fn allowed_number(field: impl Display, value: f32, allowed: Allowed) -> Result<(), Invalid> {
    let checked = allowed.check(&Datum::Single(value), |_| None);
    checked.map_err(|problem| Invalid::new(field.to_string(), problem))
}

/// Checks every value of a specification.
///
/// # Errors
/// The first invalid value: its key, the value itself, and the allowed values.
pub fn check<T>(rows: &[Parameter<T>], specification: &mut T) -> Result<(), Invalid> {
    for row in rows {
        let other = match row.allowed {
            Allowed::WholeUpTo(_, key) | Allowed::NumberUpTo(_, _, key) => value(rows, key, specification),
            _ => None,
        };
        for index in 0..row.count(specification) {
            if let Some(datum) = (row.field)(specification, index).and_then(|field| field.get()) {
                let checked = row.allowed.check(&datum, |_| other.clone());
                checked.map_err(|problem| Invalid::new(row.name(index), problem))?;
            }
        }
    }
    Ok(())
}

/// Value of a key, if the specification has one.
pub fn value<T>(rows: &[Parameter<T>], key: &str, specification: &mut T) -> Option<Datum> {
    let row = rows.iter().find(|row| row.key == key)?;
    (row.field)(specification, 0)?.get()
}
