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
mod beside;
mod compare;
mod conformance;
mod conformance_args;
mod convert;
mod documents;
mod edit;
mod elsewhere;
mod hint;
mod inspect;
mod interrupt;
mod job;
mod lights;
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
mod usage;
mod validate;
mod values;
mod view;
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

    /// The same, of one of several files.
    fn of(self, file: &std::path::Path) -> Self {
        let file = file.display().to_string();
        let named = |text: String| if text.contains(&file) { text } else { format!("{file}: {text}") };
        match self {
            Self::Usage(text) => Self::Usage(named(text)),
            Self::Cannot { message, advice } => Self::Cannot { message: named(message), advice },
            Self::Interrupted => Self::Interrupted,
        }
    }

    /// Says it.
    fn tell(&self) {
        self.tell_of(None);
    }

    /// Says it, of a command.
    fn tell_of(&self, command: Option<&str>) {
        match self {
            Self::Usage(text) => {
                let help = command.map(|name| format!("see `nephrite {name} --help`"));
                message::error(text, help.as_deref());
            }
            Self::Cannot { message, advice } => message::error(message, advice.as_deref()),
            Self::Interrupted => {}
        }
    }

    fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Cannot { .. } => ExitCode::from(1),
            Self::Interrupted => interrupt::exit_code(),
        }
    }
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let typed = usage::with_negative_numbers(std::env::args_os().collect());
    let args = match args::Args::try_parse_from(&typed) {
        Ok(args) => args,
        Err(error) => return usage::tell(error, &typed),
    };
    let name = args.command.name();
    let result = interrupt::install().and_then(|()| run(args.command));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.tell_of(Some(name));
            failure.exit_code()
        }
    }
}

fn run(command: args::Command) -> Result<(), Failure> {
    pipeline::start_threads(command.threads())?;
    match command {
        args::Command::Render(args) => render::run(*args),
        args::Command::Inspect(args) => inspect::run(&args),
        args::Command::CompareModels(args) => compare::run(*args),
        args::Command::Profile(args) => profile::run(args),
        args::Command::Edit(args) => edit::run(&args),
        args::Command::Convert(args) => convert::run(&args),
        args::Command::Presets(args) => presets::run(args),
        args::Command::Validate(args) => validate::run(&args),
        args::Command::Conformance(args) => conformance::run_suite(*args),
    }
}
