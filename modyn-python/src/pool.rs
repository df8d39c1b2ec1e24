//! Threads that share the work of a call, and that end early when Python has a signal, such as
//! Ctrl-C.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{Thread, ThreadId};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// The instructions that a thread should have, about 50 us; starting a thread takes about 20 us.
pub const INSTRUCTIONS_PER_THREAD: usize = 200_000;

/// The number of threads for a batch; zero for all processors.
pub static THREADS: AtomicUsize = AtomicUsize::new(0);

/// Returns the number of threads for a batch.
pub fn threads() -> usize {
    match THREADS.load(Ordering::Relaxed) {
        0 => {
            let all = std::thread::available_parallelism().map_or(1, usize::from);
            THREADS.store(all, Ordering::Relaxed);
            all
        }
        threads => threads,
    }
}

/// The time between two looks at Python's signals. A look takes Python's lock, for which other
/// threads may make it wait.
const BETWEEN_LOOKS: Duration = Duration::from_millis(30);

/// The instructions between two questions whether the work must end, about 0.5 ms.
pub const BETWEEN_QUESTIONS: usize = 2_000_000;

/// Threads that can share work.
pub trait Pool: Sync {
    /// Returns the number of threads, this one included.
    fn threads(&self) -> usize;

    /// Runs the chunks of this number, each on one of the threads.
    fn share(&self, chunks: usize, run: &(dyn Fn(usize) + Sync));

    /// Returns whether the work must end.
    fn must_end(&self) -> bool;
}

/// Asks at times, on one thread, whether the work must end.
pub struct Questions<'p> {
    pool: &'p dyn Pool,
    /// The instructions since the last question.
    done: usize,
}

impl<'p> Questions<'p> {
    /// Returns questions before the work.
    pub fn new(pool: &'p dyn Pool) -> Self {
        Self { pool, done: 0 }
    }

    /// Returns whether the work must end after this many further instructions.
    pub fn must_end(&mut self, instructions: usize) -> bool {
        self.done = self.done.saturating_add(instructions);
        if self.done < BETWEEN_QUESTIONS {
            return false;
        }
        self.done = 0;
        self.pool.must_end()
    }
}

/// Threads that are started for a call. Python runs its handlers of signals on the thread that
/// calls, between pieces of the work.
pub struct StartedThreads {
    caller: ThreadId,
    must_end: AtomicBool,
    /// The time of the last look at signals, and the exception that a handler has raised.
    looked: Mutex<(Instant, Option<PyErr>)>,
}

impl StartedThreads {
    /// Returns the threads of a call on this thread.
    pub fn new() -> Self {
        let looked = Mutex::new((Instant::now(), None));
        Self { caller: std::thread::current().id(), must_end: AtomicBool::new(false), looked }
    }

    /// Ends the call.
    ///
    /// # Errors
    ///
    /// The exception of a signal's handler, such as `KeyboardInterrupt`: then the work is not
    /// complete.
    pub fn finish(self) -> PyResult<()> {
        let (_, error) = self.looked.into_inner().unwrap_or_else(PoisonError::into_inner);
        error.map_or(Ok(()), Err)
    }
}

impl Pool for StartedThreads {
    fn threads(&self) -> usize {
        threads()
    }

    fn share(&self, chunks: usize, run: &(dyn Fn(usize) + Sync)) {
        if chunks == 0 {
            return;
        }
        let left = AtomicUsize::new(chunks - 1);
        std::thread::scope(|scope| {
            for chunk in 1..chunks {
                let done = Done { left: &left, caller: std::thread::current() };
                scope.spawn(move || {
                    let _done = done;
                    run(chunk);
                });
            }
            run(0);
            while left.load(Ordering::Acquire) > 0 {
                std::thread::park_timeout(BETWEEN_LOOKS);
                self.must_end();
            }
        });
    }

    fn must_end(&self) -> bool {
        if self.must_end.load(Ordering::Relaxed) {
            return true;
        }
        if std::thread::current().id() != self.caller {
            return false;
        }
        let mut looked = self.looked.lock().unwrap_or_else(PoisonError::into_inner);
        if looked.0.elapsed() < BETWEEN_LOOKS {
            return false;
        }
        let error = Python::attach(|py| py.check_signals()).err();
        *looked = (Instant::now(), error);
        self.must_end.store(looked.1.is_some(), Ordering::Relaxed);
        looked.1.is_some()
    }
}

/// Wakes the thread that calls at the end of a chunk, also where the chunk panics.
struct Done<'a> {
    left: &'a AtomicUsize,
    caller: Thread,
}

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.left.fetch_sub(1, Ordering::Release);
        self.caller.unpark();
    }
}
