//! Descriptions of values. A row says everything about one value of a specification: its key in an experiment's file,
//! its unit, what is allowed, where its default is from, what it means, and the field that holds it. Checks of
//! specifications, the reading and writing of experiments, and the reference page all come from these rows.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// A value of a specification `T`.
#[derive(Debug)]
pub struct Parameter<T> {
    /// Its key in an experiment's file, such as `noise.motor`; with `[]` for every element of a list, such as
    /// `arena.walls[].class`.
    pub key: &'static str,
    /// Its unit; empty for words, counts and shares.
    pub unit: &'static str,
    /// What it may be.
    pub allowed: Allowed,
    /// Where its default is from: a paper, another simulator, or ours.
    pub source: &'static str,
    /// What it means, in one line.
    pub about: &'static str,
    /// The field that holds it, if this specification has one. The number selects an element of a list.
    pub field: Select<T>,
}

/// Selects the field of a specification that holds a value.
pub type Select<T> = for<'a> fn(&'a mut T, usize) -> Option<&'a mut dyn Field>;

/// What a value may be, beyond its type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// Anything of the field's type.
    Any,
    /// Text, in words.
    Text(&'static str),
    /// Whole numbers from the first to the second.
    Whole(u64, u64),
    /// Whole numbers from the first up to the value of another key.
    WholeUpTo(u64, &'static str),
    /// Numbers from the first to the second.
    Number(f64, f64),
    /// Numbers from the first up to a multiple of the value of another key.
    NumberUpTo(f64, f64, &'static str),
    /// Turns: numbers from 0 to less than 1.
    Turns,
}

/// A value outside its specification.
#[derive(Clone, Debug, PartialEq)]
pub enum Datum {
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i128),
    /// A number of single precision, as kernels compute.
    Single(f32),
    /// A number of double precision.
    Double(f64),
    /// A word or a text.
    Word(String),
    /// Several values.
    List(Vec<Datum>),
    /// Values by name.
    Table(Vec<(String, Datum)>),
}

/// What can hold a value.
pub trait Field {
    /// The value, if it is set.
    fn get(&self) -> Option<Datum>;

    /// Takes a value, unless it is of another type.
    fn set(&mut self, datum: &Datum) -> bool;

    /// The type in words.
    fn kind(&self) -> &'static str;

    /// The words to choose from, and what each means; none where it is no choice.
    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        Vec::new()
    }

    /// Makes a list so many elements long, to be filled by the rows of its elements; false where it is no such list.
    fn resize(&mut self, _: usize) -> bool {
        false
    }
}

/// Each word of a choice, the value that it stands for, and what it means.
pub type Choices<C> = &'static [(&'static str, C, &'static str)];

/// A choice between words.
pub trait Choice: Clone + 'static {
    /// The words, in the order in which they are listed.
    const CHOICES: Choices<Self>;

    /// Whether it stands in an experiment with all defaults written out.
    fn is_written(&self) -> bool {
        true
    }

    /// The word of a value.
    fn word(&self) -> &'static str {
        let own = std::mem::discriminant(self);
        let found = Self::CHOICES
            .iter()
            .find(|(_, value, _)| std::mem::discriminant(value) == own);
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
            .find(|(word, ..)| matches!(datum, Datum::Word(own) if own == word));
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

/// Implements [`Field`] for a type: what it is in words, the value from data, and data from the value.
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
    fn number(&self) -> Option<f64> {
        match *self {
            Self::Whole(number) => Some(number as f64),
            Self::Single(number) => Some(f64::from(number)),
            Self::Double(number) => Some(number),
            _ => None,
        }
    }

    fn whole<T: TryFrom<i128>>(&self) -> Option<T> {
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
    |own| { Datum::Flag(*own) }
);
field!(u32, "a whole number", Datum::whole, |own| Datum::Whole((*own).into()));
field!(u64, "a whole number", Datum::whole, |own| Datum::Whole((*own).into()));
field!(
    f32,
    "a number",
    |datum| datum.number().map(|number| number as f32),
    |own| { Datum::Single(*own) }
);
field!(f64, "a number", Datum::number, |own| Datum::Double(*own));
field!(String, "text", |datum| datum.word().cloned(), |own| Datum::Word(
    own.clone()
));
field!(
    [f32; 2],
    "two numbers",
    |datum| Some(datum.pair()?.map(|number| number as f32)),
    |own| { Datum::List(own.map(Datum::Single).into()) }
);
field!([f64; 2], "two numbers", Datum::pair, |own| Datum::List(
    own.map(Datum::Double).into()
));
field!(
    (f32, f32),
    "two numbers",
    |datum| Some(datum.pair()?.map(|number| number as f32).into()),
    |own| { Datum::List(vec![Datum::Single(own.0), Datum::Single(own.1)]) }
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

/// Texts by names; none is not written.
impl Field for BTreeMap<String, String> {
    fn get(&self) -> Option<Datum> {
        let texts = self
            .iter()
            .map(|(name, text)| (name.clone(), Datum::Word(text.clone())));
        (!self.is_empty()).then(|| Datum::Table(texts.collect()))
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let Datum::Table(table) = datum else {
            return false;
        };
        let texts = table
            .iter()
            .map(|(name, text)| Some((name.clone(), text.word()?.clone())));
        let texts: Option<Self> = texts.collect();
        let is_set = texts.is_some();
        *self = texts.unwrap_or_default();
        is_set
    }

    fn kind(&self) -> &'static str {
        "a table of texts"
    }
}

/// A list whose elements have rows of their own.
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
            Self::Double(number) => write!(f, "{number}"),
            Self::Word(word) => write!(f, "{word:?}"),
            Self::List(list) => {
                let list: Vec<String> = list.iter().map(ToString::to_string).collect();
                write!(f, "[{}]", list.join(", "))
            }
            Self::Table(_) => write!(f, "a table"),
        }
    }
}

/// Numbers nearer to zero than this (about 1e-6), but not zero, are refused: kernels would come to subnormals.
pub(crate) const LEAST: f32 = 1.0 / (1 << 20) as f32;

impl Allowed {
    /// Checks a value; `other` gives the values of other keys.
    ///
    /// # Errors
    /// What the value is, and what is allowed.
    pub fn check(self, datum: &Datum, other: impl Fn(&str) -> Option<Datum> + Copy) -> Result<(), String> {
        if let Datum::List(list) = datum {
            return list.iter().try_for_each(|datum| self.check(datum, other));
        }
        if let Datum::Single(number) = *datum
            && number != 0.0
            && number.abs() < LEAST
        {
            return Err(format!("is {number:e}; allowed: 0, or {LEAST:e} and more in size"));
        }
        let is_allowed = match (self.bounded(other), datum) {
            (Self::Whole(least, greatest), Datum::Whole(number)) => {
                (i128::from(least)..=i128::from(greatest)).contains(number)
            }
            (Self::Number(least, greatest), Datum::Single(number)) => (least as f32..=greatest as f32).contains(number),
            (Self::Number(least, greatest), Datum::Double(number)) => (least..=greatest).contains(number),
            (Self::Turns, Datum::Single(number)) => (0.0..1.0).contains(number),
            _ => true,
        };
        if is_allowed {
            return Ok(());
        }
        Err(format!("is {datum}; allowed: {}", self.bounded(other)))
    }

    /// The same with the value of the key that it depends on.
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
            own => own,
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
            Self::Turns => write!(f, "0 to less than 1"),
        }
    }
}

/// Makes a row; its arguments stand in the order of a table's columns.
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
    /// How many values of this row a specification has: one, or as many as a list has elements; none where it has no
    /// such value.
    pub fn count(&self, specification: &mut T) -> usize {
        let most = if self.key.contains("[]") { usize::MAX } else { 1 };
        let is_none = |&index: &usize| (self.field)(specification, index).is_none();
        (0..most).find(is_none).unwrap_or(most)
    }

    /// The key of one of them.
    pub fn name(&self, index: usize) -> String {
        self.key.replacen("[]", &format!("[{index}]"), 1)
    }
}

/// A value that is not allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {problem}")]
pub struct Invalid {
    /// Where it stands, such as `noise.sensor` or `arena.walls[3].from`.
    pub field: String,
    /// What it is, and what is allowed.
    pub problem: String,
}

impl Invalid {
    pub(crate) fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self {
            field: field.into(),
            problem: problem.into(),
        }
    }
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

/// Checks a number; the field's name is only built for the message.
pub(crate) fn number(field: impl Display, value: f32, allowed: RangeInclusive<f32>) -> Result<(), Invalid> {
    if !allowed.contains(&value) {
        let problem = format!("is {value}; allowed: {} to {}", allowed.start(), allowed.end());
        return Err(Invalid::new(field.to_string(), problem));
    }
    allowed_number(field, value, Allowed::Any)
}

/// Checks what every number must be: finite, and not too small.
pub(crate) fn allowed_number(field: impl Display, value: f32, allowed: Allowed) -> Result<(), Invalid> {
    let checked = allowed.check(&Datum::Single(value), |_| None);
    checked.map_err(|problem| Invalid::new(field.to_string(), problem))
}

/// Checks every value of a specification.
///
/// # Errors
/// The first value that is not allowed: its key, itself, and what is allowed.
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

/// The value of a key, if a specification has one.
pub fn value<T>(rows: &[Parameter<T>], key: &str, specification: &mut T) -> Option<Datum> {
    let row = rows.iter().find(|row| row.key == key)?;
    (row.field)(specification, 0)?.get()
}
