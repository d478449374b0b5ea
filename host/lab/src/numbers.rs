//! Numbers on the command line, each checked before anything starts. Where a key of experiments means the same, its row
//! has the range.

use std::error::Error;
use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::builder::TypedValueParser;
use clap::error::{ContextKind, ContextValue};
use oneiro::parameter::Field;
use oneiro_base::exit::{Failure, Result};

use crate::experiment;

/// Reads a whole number in a range, ends included.
pub fn whole<T>(range: RangeInclusive<u64>) -> impl TypedValueParser<Value = T>
where
    T: TryFrom<u64> + Clone + Send + Sync + 'static,
{
    move |text: &str| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let number = number.and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| allowed("a whole number", range.start(), range.end()))
    }
}

/// Reads a number in a range, ends included.
pub fn number<T>(range: RangeInclusive<f64>) -> impl TypedValueParser<Value = T>
where
    T: FromStr + Into<f64> + Copy + Send + Sync + 'static,
{
    move |text: &str| {
        let number = text.parse().ok().filter(|number: &T| range.contains(&(*number).into()));
        number.ok_or_else(|| allowed("a number", range.start(), range.end()))
    }
}

fn allowed(kind: &str, least: &impl Display, greatest: &impl Display) -> String {
    format!("allowed: {kind} from {least} to {greatest}")
}

/// The range of a flag that stands for a key of experiments. A number out of it is an invalid input, as in a file.
#[derive(Debug)]
struct OutOfRange(String);

impl Display for OutOfRange {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl Error for OutOfRange {}

/// The refusal of a number that is out of the range of the key that its flag stands for.
pub fn out_of_range(error: &clap::Error) -> Option<Failure> {
    let OutOfRange(allowed) = error.source()?.downcast_ref()?;
    let (ContextValue::String(flag), ContextValue::String(number)) = (
        error.get(ContextKind::InvalidArg)?,
        error.get(ContextKind::InvalidValue)?,
    ) else {
        return None;
    };
    let flag = flag.split(' ').next().unwrap_or(flag);
    Some(Failure::input(format_args!("{flag}: is {number}; {allowed}")))
}

/// Reads a number that the row of a key allows.
pub fn of_key<T>(key: &'static str) -> impl TypedValueParser<Value = T>
where
    T: FromStr + Field + Default + Clone + Send + Sync + 'static,
{
    move |text: &str| -> std::result::Result<T, Box<dyn Error + Send + Sync>> {
        allowed_by(key, text).map_err(|allowed| match text.parse::<f64>() {
            Ok(_) => OutOfRange(allowed).into(),
            Err(_) => allowed.into(),
        })
    }
}

fn allowed_by<T: FromStr + Field + Default>(key: &str, text: &str) -> std::result::Result<T, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &T| experiment::allows(key, number).0);
    number.ok_or_else(|| format!("allowed: {}", experiment::allows(key, &T::default()).1))
}

/// Reads a seed.
pub fn seed() -> impl TypedValueParser<Value = u64> {
    |text: &str| allowed_by(experiment::SEED, text)
}

/// Checks a seed that another program gives.
///
/// # Errors
/// Exit 3: the seed, and the allowed ones.
pub fn check_seed(seed: u64) -> Result {
    let key = experiment::SEED;
    match experiment::allows(key, &seed) {
        (true, _) => Ok(()),
        (false, allowed) => Err(Failure::input(format_args!("{key}: is {seed}; allowed: {allowed}"))),
    }
}
