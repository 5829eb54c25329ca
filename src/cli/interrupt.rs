//! Signals that ask to stop. While there is nothing to lose (reading, building) the first one ends the program; once
//! something is worth finishing it asks for that, and the second one ends the program. Temporary files are removed, and
//! other programs that were started end, too.

use super::Failure;
use super::message;
use crate::conformance::end_renderers;
use crate::film::atomic::remove_temporaries;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static FINISHES: AtomicBool = AtomicBool::new(false);

/// Exit code of an interrupted program, 128 + SIGINT.
const INTERRUPTED: u8 = 130;
/// Signals that follow the first one so soon are the same one: `timeout` signals the program and its process group, a
/// closed terminal may signal in several ways.
const SAME: Duration = Duration::from_millis(500);
/// Longest time that a message may take: whoever reads standard error may have stopped reading.
const PATIENCE: Duration = Duration::from_millis(100);

/// Starts listening to the signals that are not ignored: `nohup`, and shells that start programs in the background, ask
/// for that.
pub(super) fn install() -> Result<(), Failure> {
    let cannot =
        |error: &dyn std::fmt::Display| Failure::cannot(format!("cannot listen for interrupts: {error}"));
    #[cfg(unix)]
    let ignored = unix::ignored().map_err(|e| cannot(&e))?;
    let mut first: Option<Instant> = None;
    let handler = move || match first {
        Some(first) if first.elapsed() < SAME => {}
        Some(_) => leave(),
        None => {
            first = Some(Instant::now());
            if FINISHES.load(Ordering::SeqCst) {
                tell("stopping; what is finished will be written (interrupt again to stop at once)");
                REQUESTED.store(true, Ordering::SeqCst);
            } else {
                tell("interrupted");
                leave();
            }
        }
    };
    ctrlc::set_handler(handler).map_err(|e| cannot(&e))?;
    #[cfg(unix)]
    unix::ignore(&ignored).map_err(|e| cannot(&e))?;
    Ok(())
}

/// From now on there is something worth finishing.
pub(super) fn finish_at_first() {
    FINISHES.store(true, Ordering::SeqCst);
}

/// Whether somebody asked to stop.
pub(super) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// The exit code of a command that was interrupted.
pub(super) fn exit_code() -> std::process::ExitCode {
    INTERRUPTED.into()
}

/// Says something on a line of its own, unless that takes too long: a pipe that nobody reads is full one day.
fn tell(text: &'static str) {
    let (sender, said) = mpsc::channel();
    let speaker = std::thread::Builder::new().spawn(move || {
        message::line(&format!("\n{text}"));
        // Whoever waits may have lost patience.
        let _ = sender.send(());
    });
    if speaker.is_ok() {
        let _ = said.recv_timeout(PATIENCE);
    }
}

/// Ends the program at once.
fn leave() -> ! {
    remove_temporaries();
    end_renderers();
    std::process::exit(INTERRUPTED.into())
}

#[cfg(unix)]
mod unix {
    use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, sigaction};

    /// The signals that are listened to.
    const ALL: [Signal; 3] = [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP];

    /// Those of them that whoever started this program wants to be ignored.
    pub fn ignored() -> nix::Result<Vec<Signal>> {
        let ignore = SigAction::new(SigHandler::SigIgn, SaFlags::empty(), SigSet::empty());
        let mut found = Vec::new();
        for signal in ALL {
            // There is no asking without setting.
            // SAFETY: no handler is installed here that could be called.
            let before = unsafe { sigaction(signal, &ignore) }?;
            if matches!(before.handler(), SigHandler::SigIgn) {
                found.push(signal);
            } else {
                // SAFETY: what was there before was valid.
                unsafe { sigaction(signal, &before) }?;
            }
        }
        Ok(found)
    }

    /// Ignores signals.
    pub fn ignore(signals: &[Signal]) -> nix::Result<()> {
        let ignore = SigAction::new(SigHandler::SigIgn, SaFlags::empty(), SigSet::empty());
        for &signal in signals {
            // SAFETY: no handler is installed.
            unsafe { sigaction(signal, &ignore) }?;
        }
        Ok(())
    }
}
