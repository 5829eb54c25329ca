//! The command line: one file a command.
//!
//! What was typed is not what it means: clap's `args` become a validated `job`, and only the job reaches the
//! library, through `pipeline`. Pictures go to files, what a command was asked to print to standard output,
//! everything else to standard error.
//!
//! | exit code | meaning |
//! | --- | --- |
//! | 0 | done |
//! | 1 | cannot render or read; one message says why, where (a JSON pointer) and what to do |
//! | 2 | the command line makes no sense |
//! | 130 | interrupted; what was rendered has been written, if anything was |

mod animation;
mod args;
mod author_args;
mod author_values;
mod authored;
mod compare;
mod conformance;
mod conformance_args;
mod convert;
mod edit;
mod inspect;
mod interrupt;
mod job;
mod message;
mod names;
mod pipeline;
mod presets;
mod profile;
mod progress;
mod progressive;
mod render;
mod setup;
mod stats;
mod validate;
mod values;
mod warnings;

use clap::Parser;
use std::process::ExitCode;

/// Why a command did not do what was asked.
#[derive(Debug)]
enum Failure {
    /// The command line makes no sense.
    Usage(String),
    /// It cannot be done.
    Cannot {
        /// What is wrong, and where.
        message: String,
        /// What could be done about it.
        advice: Option<String>,
    },
    /// Somebody pressed Ctrl-C; all has been said.
    Interrupted,
}

impl Failure {
    fn cannot(message: impl ToString) -> Self {
        Self::Cannot { message: message.to_string(), advice: None }
    }

    fn advise(message: impl ToString, advice: impl Into<String>) -> Self {
        Self::Cannot { message: message.to_string(), advice: Some(advice.into()) }
    }
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let args = match args::Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            // Standard error may be closed; there is nobody left to tell.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let result = match args.command {
        args::Command::Render(args) => render::run(*args),
        args::Command::Inspect(args) => inspect::run(&args),
        args::Command::CompareModels(args) => compare::run(*args),
        args::Command::Profile(args) => profile::run(args),
        args::Command::Edit(args) => edit::run(&args),
        args::Command::Convert(args) => convert::run(&args),
        args::Command::Presets(args) => presets::run(args),
        args::Command::Validate(args) => validate::run(&args),
        args::Command::Conformance(args) => conformance::run_suite(*args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(text)) => {
            message::error(&text, Some("see `nephrite --help`"));
            ExitCode::from(2)
        }
        Err(Failure::Cannot { message, advice }) => {
            message::error(&message, advice.as_deref());
            ExitCode::from(1)
        }
        Err(Failure::Interrupted) => ExitCode::from(130),
    }
}
