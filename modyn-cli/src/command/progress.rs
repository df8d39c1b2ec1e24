//! The progress display of long operations.

use std::io::{IsTerminal as _, Write as _};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};

/// A line on standard error with the current operation and its duration, until it is stopped or
/// dropped. Nothing is shown if standard error is not a terminal.
pub struct Progress(Option<Shown>);

struct Shown {
    /// Changes the operation; the display ends when this is dropped.
    messages: Sender<&'static str>,
    thread: JoinHandle<()>,
}

const PERIOD: Duration = Duration::from_millis(200);
const FRAMES: [&str; 4] = ["-", "\\", "|", "/"];

impl Progress {
    /// Starts the display with an operation.
    pub fn start(what: &'static str) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let (messages, received) = channel();
        let thread = spawn(move || {
            let start = Instant::now();
            let mut what = what;
            let show = |text: &str| {
                // Erases the line first.
                let mut err = anstream::stderr().lock();
                let _ = write!(err, "\r\x1b[K{text}").and_then(|()| err.flush());
            };
            for frame in FRAMES.iter().cycle() {
                show(&format!("{frame} {what} ({} s)", start.elapsed().as_secs()));
                match received.recv_timeout(PERIOD) {
                    Ok(next) => what = next,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            show("");
        });
        Self(Some(Shown { messages, thread }))
    }

    /// Changes the operation.
    pub fn show(&self, what: &'static str) {
        if let Some(shown) = &self.0 {
            // A send fails only after the thread has ended, when nothing can be shown.
            let _ = shown.messages.send(what);
        }
    }

    /// Ends the display, and erases the line.
    pub fn stop(&mut self) {
        if let Some(Shown { messages, thread }) = self.0.take() {
            drop(messages);
            let _ = thread.join();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.stop();
    }
}
