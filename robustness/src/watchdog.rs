//! Ends the process if a case takes too long, with its number: a hang is a finding as well.

use std::{
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

/// Maximum processor time of a case, sanitizers included.
const PATIENCE_S: f64 = 120.0;

static CASE: AtomicU64 = AtomicU64::new(0);

/// Sets the running case.
pub fn begin(case: u64) {
    CASE.store(case + 1, Ordering::Relaxed);
}

/// Starts watching, in a separate thread.
pub fn start() {
    let clock = Instant::now();
    std::thread::spawn(move || {
        let (mut seen, mut since) = (0, 0.0);
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let case = CASE.load(Ordering::Relaxed);
            // A process that gets no processor time does not hang.
            let now = processor_s().unwrap_or_else(|| clock.elapsed().as_secs_f64());
            if case != seen {
                (seen, since) = (case, now);
            } else if case != 0 && now - since > PATIENCE_S {
                eprintln!("case {} hangs", case - 1);
                std::process::abort();
            }
        }
    });
}

/// Processor time of this process, if the system reports it as Linux does.
fn processor_s() -> Option<f64> {
    const TICKS_PER_S: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is a name in parentheses, which may contain blanks; user and system time are the 14th and 15th.
    let mut fields = text.rsplit_once(')')?.1.split_ascii_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_PER_S)
}
