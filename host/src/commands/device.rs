//! `oneiro device`: this machine's devices: what they are, whether their bits are right, and how fast they are.

use oneiro_base::console::Console;
use oneiro_base::exit::Result;

use crate::cli::{Device, DeviceCommand};

mod bench;
pub(crate) mod list;
mod machine_code;
pub(crate) mod test;

/// Runs the subcommand.
pub(crate) fn run(arguments: &Device, console: Console) -> Result {
    match &arguments.command {
        DeviceCommand::List(arguments) => console.print_answer(&list::answer(arguments.explain)),
        DeviceCommand::Test(arguments) => test::run(arguments, console),
        DeviceCommand::Bench(arguments) => bench::run(arguments, console),
    }
}
