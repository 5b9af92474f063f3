//! Threads of one's own, which are gone when their owner is.
//!
//! A rayon pool that is dropped tells its threads to end, and does not wait for them. Whoever unloads the library then, as a program
//! does with a plug-in, takes away the code that they are still running. So the handles are kept here, and waited for.

use std::ops::Deref;
use std::thread::{Builder, JoinHandle};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// A rayon pool whose threads have ended when it has been dropped. Not to be dropped by one of them.
#[derive(Debug)]
pub struct Threads {
    /// Always there, but while it is dropped.
    pool: Option<ThreadPool>,
    handles: Vec<JoinHandle<()>>,
}

impl Threads {
    /// So many threads; 0: as many as the machine runs at once.
    ///
    /// # Errors
    /// If the operating system gives no threads.
    pub fn new(count: usize) -> Result<Threads, ThreadPoolBuildError> {
        let mut handles = Vec::new();
        let pool = ThreadPoolBuilder::new()
            .num_threads(count)
            .spawn_handler(|thread| {
                handles.push(Builder::new().spawn(|| thread.run())?);
                Ok(())
            })
            .build();
        // Those that were begun before one could not be are told to end, and waited for.
        let (pool, error) = match pool {
            Ok(pool) => (Some(pool), None),
            Err(error) => (None, Some(error)),
        };
        let threads = Threads { pool, handles };
        error.map_or(Ok(threads), Err)
    }
}

impl Deref for Threads {
    type Target = ThreadPool;

    fn deref(&self) -> &ThreadPool {
        self.pool.as_ref().expect("the pool is there until the end")
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.pool = None;
        for handle in self.handles.drain(..) {
            // What a task panicked with has been passed on to who waited for it.
            let _ = handle.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Duration;

    use super::*;

    #[test]
    fn no_thread_outlives_its_owner() {
        static RUNNING: AtomicU32 = AtomicU32::new(0);
        struct Running;
        impl Drop for Running {
            fn drop(&mut self) {
                // Long enough for a test that does not wait to fail.
                std::thread::sleep(Duration::from_millis(50));
                RUNNING.fetch_sub(1, Ordering::SeqCst);
            }
        }
        thread_local!(static OF_THREAD: Running = {
            RUNNING.fetch_add(1, Ordering::SeqCst);
            Running
        });
        let threads = Threads::new(3).expect("three threads");
        threads.broadcast(|_| OF_THREAD.with(|_| {}));
        assert_eq!(RUNNING.load(Ordering::SeqCst), 3);
        drop(threads);
        assert_eq!(RUNNING.load(Ordering::SeqCst), 0);
    }
}
