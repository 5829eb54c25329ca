//! Measurements for `--stats`: where the time went, what was done, how much memory it took.

use std::time::Instant;

/// Wall-clock time since it was started or last read.
#[derive(Debug)]
pub(super) struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start or the last lap.
    pub fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let seconds = (now - self.0).as_secs_f64();
        self.0 = now;
        seconds
    }
}

/// What a piece of work took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Work {
    /// Wall-clock time.
    pub seconds: f64,
    /// CPU time of all threads, in steps of 10 ms; `None` where the system does not tell.
    pub cpu_seconds: Option<f64>,
}

impl Work {
    /// Does something, and says what it took.
    pub fn of<T>(work: impl FnOnce() -> T) -> (T, Self) {
        let cpu_before = cpu_seconds();
        let mut watch = Stopwatch::start();
        let result = work();
        let seconds = watch.lap();
        let hundredths = |before: f64| Some(((cpu_seconds()? - before) * 100.0).round() / 100.0);
        (result, Self { seconds, cpu_seconds: cpu_before.and_then(hundredths) })
    }
}

/// CPU seconds of all threads of this process so far, finished ones included, in steps of 10 ms; `None` where the
/// system does not tell.
fn cpu_seconds() -> Option<f64> {
    /// `USER_HZ`, the unit of times in `/proc`: 100 on every architecture that Rust's tier 1 and 2 Linux targets run on.
    const TICKS_A_SECOND: f64 = 100.0;
    parse_cpu_ticks(&std::fs::read_to_string("/proc/self/stat").ok()?)
        .map(|ticks| ticks as f64 / TICKS_A_SECOND)
}

/// Largest resident memory of this process so far, in bytes; `None` where the system does not tell.
pub(super) fn peak_memory_bytes() -> Option<u64> {
    parse_peak(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// utime + stime of proc(5): fields 14 and 15, counted after the program's name, which may hold spaces and brackets.
fn parse_cpu_ticks(stat: &str) -> Option<u64> {
    let after_name = stat.rsplit_once(')')?.1;
    let mut fields = after_name.split_whitespace().skip(11);
    Some(fields.next()?.parse::<u64>().ok()? + fields.next()?.parse::<u64>().ok()?)
}

fn parse_peak(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proc_files_are_read_past_odd_program_names() {
        let stat = "1234 (a) b (c) R 1 2 3 4 5 6 7 8 9 10 250 50 0 0 20 0 1 0 100 0 0";
        assert_eq!(parse_cpu_ticks(stat), Some(300));
        assert_eq!(parse_cpu_ticks("garbage"), None);
        assert_eq!(parse_peak("VmPeak:\t 9 kB\nVmHWM:\t    2048 kB\n"), Some(2048 * 1024));
        assert_eq!(parse_peak("VmPeak: 9 kB"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_has_used_memory_and_time() {
        assert!(peak_memory_bytes().unwrap() > 1 << 20);
        assert!(cpu_seconds().unwrap() >= 0.0);
    }
}
