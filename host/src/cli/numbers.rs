//! Flags with numbers: each says itself which numbers are allowed, and is checked before anything starts. Where a key of experiments
//! means the same, its row has the range.

use std::any::TypeId;
use std::error::Error;
use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::TypedValueParser;
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command};
use oneiro::parameter::Field;
use oneiro_base::exit::Failure;
use oneiro_lab::experiment;
use oneiro_lab::sweep::store::Shard;

use super::Speed;

/// Reads a whole number in a range, ends included.
pub(super) fn whole<T>(range: RangeInclusive<u64>) -> impl TypedValueParser<Value = T>
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
pub(super) fn number<T>(range: RangeInclusive<f64>) -> impl TypedValueParser<Value = T>
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
pub(super) fn out_of_range(error: &clap::Error) -> Option<Failure> {
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
pub(super) fn of_key<T>(key: &'static str) -> impl TypedValueParser<Value = T>
where
    T: FromStr + Field + Default + Clone + Send + Sync + 'static,
{
    move |text: &str| -> Result<T, Box<dyn Error + Send + Sync>> {
        allowed_by(key, text).map_err(|allowed| match text.parse::<f64>() {
            Ok(_) => OutOfRange(allowed).into(),
            Err(_) => allowed.into(),
        })
    }
}

fn allowed_by<T: FromStr + Field + Default>(key: &str, text: &str) -> Result<T, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &T| experiment::allows(key, number).0);
    number.ok_or_else(|| format!("allowed: {}", experiment::allows(key, &T::default()).1))
}

/// Reads a seed.
pub(super) fn seed() -> impl TypedValueParser<Value = u64> {
    |text: &str| allowed_by(experiment::SEED, text)
}

/// Lets each flag with a number read a text that begins with a hyphen, so that its own message refuses a negative number.
pub(super) fn with_hyphens(command: Command) -> Command {
    let command = command.mut_args(|arg| {
        let is_number = takes_number(&arg);
        arg.allow_hyphen_values(is_number)
    });
    command.mut_subcommands(with_hyphens)
}

/// Whether a flag takes a number, or a text made of numbers.
fn takes_number(arg: &Arg) -> bool {
    let numbers = [
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<f32>(),
        TypeId::of::<f64>(),
        TypeId::of::<[f32; 3]>(),
        TypeId::of::<RangeInclusive<u64>>(),
        TypeId::of::<Duration>(),
        TypeId::of::<Speed>(),
        TypeId::of::<Shard>(),
    ];
    let own = arg.get_value_parser().type_id();
    arg.get_action().takes_values() && numbers.iter().any(|number| own == *number)
}

#[cfg(test)]
mod tests {
    use clap::error::ErrorKind;

    use super::*;

    /// Every flag with a number says which numbers are allowed, whatever text it is given.
    #[test]
    fn each_flag_says_which_numbers_are_allowed() {
        fn walk(command: &Command, path: &str, flags: &mut u32) {
            for arg in command.get_arguments().filter(|arg| takes_number(arg)) {
                for wrong in ["-1", "-0.5", "-1..2", "x", "nan", "", "1e999", "18446744073709551616"] {
                    let words = match arg.get_long() {
                        Some(long) => vec!["oneiro".to_owned(), format!("--{long}"), wrong.to_owned()],
                        None => vec!["oneiro".to_owned(), wrong.to_owned()],
                    };
                    let error = command.clone().try_get_matches_from(words).unwrap_err();
                    let text = error.to_string();
                    let is_told = error.kind() == ErrorKind::ValueValidation && text.contains("allowed: ");
                    assert!(is_told, "{path} --{:?} {wrong:?}: {text}", arg.get_long());
                }
                *flags += 1;
            }
            for command in command.get_subcommands() {
                walk(command, &format!("{path} {}", command.get_name()), flags);
            }
        }
        let mut command = super::super::command();
        command.build();
        let mut flags = 0;
        walk(&command, "oneiro", &mut flags);
        assert!(flags > 60, "{flags}");
    }

    /// A seed of every flag that takes one is in the range of the key.
    #[test]
    fn each_seed_is_one_that_a_run_can_read_again() {
        fn walk(command: &Command, flags: &mut u32) {
            for arg in command.get_arguments() {
                let Some(long @ ("seed" | "seeds")) = arg.get_long() else {
                    continue;
                };
                let beyond = if long == "seed" {
                    "9223372036854775808"
                } else {
                    "9223372036854775807..9223372036854775808"
                };
                let error = command
                    .clone()
                    .try_get_matches_from(["oneiro", &format!("--{long}"), beyond]);
                let text = error.unwrap_err().to_string();
                assert!(
                    text.contains("9223372036854775807"),
                    "{} --{long}: {text}",
                    command.get_name()
                );
                *flags += 1;
            }
            for command in command.get_subcommands() {
                walk(command, flags);
            }
        }
        let mut command = super::super::command();
        command.build();
        let mut flags = 0;
        walk(&command, &mut flags);
        assert!(flags >= 8, "{flags}");
    }
}
