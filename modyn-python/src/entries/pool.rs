//! Threads that share the work of a call.

/// Threads that can share work.
pub trait Pool: Sync {
    /// Returns the number of threads, this one included.
    fn threads(&self) -> usize;

    /// Runs the chunks of this number, each on one of the threads.
    fn share(&self, chunks: usize, run: &(dyn Fn(usize) + Sync));
}

/// Threads that are started for a call.
pub struct StartedThreads;

impl Pool for StartedThreads {
    fn threads(&self) -> usize {
        crate::function::threads()
    }

    fn share(&self, chunks: usize, run: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| {
            for chunk in 1..chunks {
                scope.spawn(move || run(chunk));
            }
            if chunks > 0 {
                run(0);
            }
        });
    }
}
