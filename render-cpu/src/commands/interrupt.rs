//! Ctrl-C and the other signals that ask a run to end.
//!
//! The first one asks: what is under way is finished, files are written. The second one ends the program. A hang-up that the
//! shell has been told to ignore (`nohup`) stays ignored.

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
    let was_ignored = hang_up::is_ignored();
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
    if was_ignored {
        hang_up::ignore();
    }
    request
}

#[cfg(unix)]
mod hang_up {
    /// Whether whoever started the program had hang-ups ignored.
    pub fn is_ignored() -> bool {
        // SAFETY: all-zero bytes are a valid `sigaction`, and the call only writes to it.
        unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            libc::sigaction(libc::SIGHUP, std::ptr::null(), &mut action) == 0
                && action.sa_sigaction == libc::SIG_IGN
        }
    }

    /// Ignores them again.
    pub fn ignore() {
        // SAFETY: ignoring a signal runs no code.
        unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
    }
}

#[cfg(not(unix))]
mod hang_up {
    pub fn is_ignored() -> bool {
        false
    }

    pub fn ignore() {}
}
