//! Criterion benchmarks of the hot loops, and [`Race`] where a loaded machine would spoil a mean; see the README beside this
//! file.

use std::time::Instant;

/// Functions whose times are compared: in every round each of them runs one batch of calls, one after the other, and each is
/// given its shortest batch. What else the machine does lengthens batches but does not shorten one, and falls on all alike.
#[derive(Default)]
pub struct Race<'a> {
    entries: Vec<Entry<'a>>,
}

struct Entry<'a> {
    calls: u32,
    batch: Box<dyn FnMut() + 'a>,
    nanoseconds: f64,
}

/// Rounds of a race under `cargo bench`; a single one otherwise, which tells that it runs.
const ROUNDS: u32 = 3000;

impl<'a> Race<'a> {
    /// Nobody yet.
    pub fn new() -> Race<'a> {
        Race::default()
    }

    /// Adds a function, `calls` of which make a batch, and returns its place.
    pub fn add<T>(&mut self, calls: u32, mut f: impl FnMut() -> T + 'a) -> usize {
        self.entries.push(Entry {
            calls,
            batch: Box::new(move || {
                for _ in 0..calls {
                    std::hint::black_box(f());
                }
            }),
            nanoseconds: f64::MAX,
        });
        self.entries.len() - 1
    }

    /// Nanoseconds per call of each function, in the order in which they were added.
    pub fn run(mut self) -> Vec<f64> {
        let measured = std::env::args().any(|argument| argument == "--bench");
        for _ in 0..if measured { ROUNDS } else { 1 } {
            for entry in &mut self.entries {
                let start = Instant::now();
                (entry.batch)();
                let time = start.elapsed().as_nanos() as f64 / f64::from(entry.calls);
                entry.nanoseconds = entry.nanoseconds.min(time);
            }
        }
        self.entries.iter().map(|e| e.nanoseconds).collect()
    }
}
