//! Ctrl-C and the other signals that ask a run to end.
//!
//! The first one requests the end: the current pass is finished, files are written. The second one ends the program. A hang-up that the
//! shell has been told to ignore (`nohup`) stays ignored, and so does the Ctrl-C that it ignores for what runs in the background of
//! a script.

use crate::say::note;
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a run that was interrupted, as shells report SIGINT.
pub const EXIT_INTERRUPTED: u8 = 130;

/// A request to stop, which signals set from now on.
pub fn request(quiet: bool) -> Arc<AtomicBool> {
    let request = Arc::new(AtomicBool::new(false));
    let flag = request.clone();
    let ignored = ignored::signals();
    let installed = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            process::exit(EXIT_INTERRUPTED.into());
        }
        if !quiet {
            // Below the ^C that the terminal shows.
            note("\ninterrupted: what there is will be written; once more ends at once, without");
        }
    });
    if let Err(error) = installed {
        tracing::debug!("Ctrl-C ends the program at once: {error}");
    }
    ignored::restore(ignored);
    request
}

/// What the program that started this one had ignored: hang-ups (`nohup`), and Ctrl-C of what a script runs in the background.
#[cfg(unix)]
mod ignored {
    const SIGNALS: [libc::c_int; 2] = [libc::SIGHUP, libc::SIGINT];

    /// The signals that are ignored.
    pub fn signals() -> Vec<libc::c_int> {
        let is_ignored = |signal: &libc::c_int| {
            // SAFETY: all-zero bytes are a valid `sigaction`, and the call only writes to it.
            unsafe {
                let mut action: libc::sigaction = std::mem::zeroed();
                libc::sigaction(*signal, std::ptr::null(), &mut action) == 0
                    && action.sa_sigaction == libc::SIG_IGN
            }
        };
        SIGNALS.into_iter().filter(is_ignored).collect()
    }

    /// Ignores them again.
    pub fn restore(signals: Vec<libc::c_int>) {
        for signal in signals {
            // SAFETY: ignoring a signal runs no code.
            unsafe { libc::signal(signal, libc::SIG_IGN) };
        }
    }
}

#[cfg(not(unix))]
mod ignored {
    pub fn signals() -> Vec<i32> {
        Vec::new()
    }

    pub fn restore(_: Vec<i32>) {}
}
