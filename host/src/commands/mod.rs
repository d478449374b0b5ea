//! The commands, one file each; those with sub-commands have a folder.

use oneiro_base::console::Console;
#[cfg(not(feature = "compose"))]
use oneiro_base::exit::Failure;
use oneiro_base::exit::Result;
#[cfg(unix)]
use oneiro_lab::engine::signals::stop_at_once;

use crate::cli::Command;

pub(crate) mod adopt;
mod check;
mod compare;
mod completions;
pub(crate) mod cost;
pub(crate) mod device;
mod evaluate;
#[cfg(feature = "compose")]
mod export;
pub(crate) mod fleet;
mod guard;
mod import;
mod list;
mod live;
mod man;
mod new;
mod on_board;
pub(crate) mod places;
mod replay;
mod report;
mod reproduce;
mod resume;
pub(crate) mod robot;
pub(crate) mod rules;
mod run;
mod slurm;
mod subjects;
pub(crate) mod sweep;
mod verify;
mod watch;

/// Runs a command.
pub(crate) fn run(command: Command, console: Console) -> Result {
    // What they record can be continued, so they end in the same way whenever they are stopped.
    #[cfg(unix)]
    if matches!(
        command,
        Command::Run(_) | Command::Adopt(_) | Command::Resume(_) | Command::Sweep(_) | Command::Reproduce(_)
    ) {
        stop_at_once()?;
    }
    match command {
        Command::New(arguments) => new::run(&arguments, console),
        Command::Import(arguments) => import::run(&arguments, console),
        Command::Check(arguments) => check::run(&arguments, console),
        Command::Run(arguments) => run::run(&arguments, console),
        Command::Adopt(arguments) => adopt::run(arguments, console),
        Command::Resume(arguments) => resume::run(&arguments, console),
        Command::Evaluate(arguments) => evaluate::run(&arguments, console),
        #[cfg(feature = "compose")]
        Command::Export(arguments) => export::run(&arguments, console),
        #[cfg(not(feature = "compose"))]
        Command::Export(_) => Err(Failure::usage(
            "this program compiles nothing, so it exports nothing; allowed: in one with the feature `compose`",
        )),
        Command::Compare(arguments) => compare::run(&arguments, console),
        Command::Watch(arguments) => watch::run(&arguments, console),
        Command::Replay(arguments) => replay::run(&arguments, console),
        Command::Verify(arguments) => verify::run(&arguments, console),
        Command::List(arguments) => list::run(&arguments, console),
        Command::Device(arguments) => device::run(&arguments, console),
        Command::Robot(arguments) => robot::run(&arguments, console),
        Command::OnBoard(arguments) => on_board::run(&arguments, console),
        Command::Guard(arguments) => guard::run(arguments),
        Command::Fleet(arguments) => fleet::run(&arguments, console),
        Command::Reproduce(arguments) => reproduce::run(&arguments, console),
        Command::Sweep(arguments) => sweep::run(&arguments, console),
        Command::Completions(arguments) => completions::run(&arguments, console),
        Command::Man(arguments) => man::run(&arguments, console),
    }
}
