//! Flags with numbers: each says itself which numbers are allowed.

use std::any::TypeId;
use std::ops::RangeInclusive;
use std::time::Duration;

use clap::{Arg, Command};
use oneiro_lab::sweep::store::Shard;

use super::Speed;

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
