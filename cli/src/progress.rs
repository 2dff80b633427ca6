//! Progress of work that takes longer than a second, with the remaining time: drawn on standard error if that is a terminal; as lines of
//! JSON if the environment requests them (`ACTUATOR_PROGRESS=lines`), for programs that call this one; otherwise not at all.

pub mod estimate;

use std::{
    io::IsTerminal,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::output;
use estimate::{Expectation, Shown, spoken};

/// Shorter work shows nothing [s].
const SHOWN_AFTER_S: f64 = 1.0;

/// Between two drawings.
const INTERVAL: Duration = Duration::from_millis(100);

/// Between two lines.
const INTERVAL_OF_LINES: Duration = Duration::from_millis(500);

/// Environment variable that requests lines.
const VARIABLE: &str = "ACTUATOR_PROGRESS";

/// The drawn text, so that an interruption can clear it.
static DRAWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Work in progress, shown until this is dropped.
pub struct Progress {
    shared: Arc<Shared>,
    ticker: Option<JoinHandle<()>>,
}

struct Shared {
    work: Mutex<Work>,
    over: Condvar,
    began: Instant,
}

struct Work {
    words: String,
    expectation: Expectation,
    /// Start of the present step [s].
    began_s: f64,
    shown: Shown,
    is_over: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }
}

/// Where progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Terminal,
    Lines,
}

fn place() -> Option<Place> {
    if std::env::var_os(VARIABLE).is_some_and(|value| value == "lines") {
        return Some(Place::Lines);
    }
    std::io::stderr().is_terminal().then_some(Place::Terminal)
}

impl Progress {
    /// The name of new work, and what is known of it.
    #[must_use]
    pub fn new(words: impl Into<String>, expectation: Expectation) -> Self {
        let work = Work { words: words.into(), expectation, began_s: 0.0, shown: Shown::default(), is_over: false };
        let shared = Arc::new(Shared { work: Mutex::new(work), over: Condvar::new(), began: Instant::now() });
        let ticker = place().map(|place| {
            let shared = Arc::clone(&shared);
            std::thread::spawn(move || tick(&shared, place))
        });
        Self { shared, ticker }
    }

    /// Starts another step.
    pub fn step(&self, words: impl Into<String>, expectation: Expectation) {
        let mut work = self.shared.lock();
        (work.words, work.expectation, work.began_s) = (words.into(), expectation, self.shared.now_s());
    }

    /// Sets the completed fraction of the present step.
    pub fn share(&self, share: f64) {
        let mut work = self.shared.lock();
        let now_s = self.shared.now_s() - work.began_s;
        work.expectation.hear(share, now_s);
    }

    /// Sets the number of completed parts of the present step, and the name of the next one.
    pub fn done(&self, parts: u64, words: impl Into<String>) {
        let mut work = self.shared.lock();
        work.words = words.into();
        let now_s = self.shared.now_s() - work.began_s;
        work.expectation.advance(parts, now_s);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.shared.lock().is_over = true;
        self.shared.over.notify_all();
        if let Some(ticker) = self.ticker.take() {
            let _ = ticker.join();
        }
    }
}

/// Shows the state periodically, until the work ends.
fn tick(shared: &Shared, place: Place) {
    let interval = if place == Place::Terminal { INTERVAL } else { INTERVAL_OF_LINES };
    let mut work = shared.lock();
    while !work.is_over {
        let now_s = shared.now_s();
        let estimate_s = work.expectation.left_s(now_s - work.began_s);
        let left_s = work.shown.update(now_s, estimate_s);
        if now_s >= SHOWN_AFTER_S {
            match place {
                Place::Terminal => draw(&work.words, now_s, left_s),
                Place::Lines => {
                    let line = json!({ "progress": work.words, "elapsed_s": now_s, "left_s": left_s });
                    output::remark(&line.to_string());
                }
            }
        }
        work = shared.over.wait_timeout(work, interval).unwrap_or_else(PoisonError::into_inner).0;
    }
    clear();
}

/// Parts of the bar.
const BAR: u64 = 1000;

fn draw(words: &str, now_s: f64, left_s: Option<f64>) {
    let mut drawn = DRAWN.lock().unwrap_or_else(PoisonError::into_inner);
    let bar = drawn.get_or_insert_with(|| {
        let bar = ProgressBar::new(BAR);
        if let Ok(style) = ProgressStyle::with_template("{bar:20} {msg}") {
            bar.set_style(style);
        }
        bar
    });
    let share = left_s.map_or(0.0, |left| now_s / (now_s + left));
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    // a position on the bar
    bar.set_position((share * BAR as f64) as u64);
    let left = left_s.map_or(String::new(), |left| format!(", about {} left", spoken(left)));
    bar.set_message(format!("{words}, {now_s:.0} s{left}"));
}

/// Clears the drawn text from the terminal.
fn clear() {
    take_off(&mut DRAWN.lock().unwrap_or_else(PoisonError::into_inner));
}

/// As above, permanently: any further drawing blocks from now on.
pub fn end() {
    let mut drawn = DRAWN.lock().unwrap_or_else(PoisonError::into_inner);
    take_off(&mut drawn);
    std::mem::forget(drawn);
}

fn take_off(drawn: &mut Option<ProgressBar>) {
    if let Some(bar) = drawn.take() {
        bar.finish_and_clear();
    }
}
