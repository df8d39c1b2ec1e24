//! A sign of life while something takes long, for who watches.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Shown on standard error until it is stopped or dropped, if that is a terminal.
pub struct Progress(ProgressBar);

impl Progress {
    /// Says what is going on, and for how long.
    pub fn start(what: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(what);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// Says what is going on now.
    pub fn then(&self, what: &'static str) {
        self.0.set_message(what);
    }

    /// Leaves no trace.
    pub fn stop(&self) {
        self.0.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.stop();
    }
}
