//! Times of day and dates, as loggers write them: `12:34:56.789`, `2026-01-02T12:34:56.789Z`, `2026-01-02 12:34:56+01:00`.
//!
//! Our own, since a crate of calendars and time zones would be larger than all that reads records.

/// An instant as whole seconds and a fraction, so that differences over years keep their microseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeStamp {
    seconds: i64,
    fraction: f64,
    /// Without a date: midnight comes between 23:59:59 and 00:00:00.
    of_day: bool,
}

const DAY_S: i64 = 86_400;

impl TimeStamp {
    /// Reads a stamp; none where the text is no such thing.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (date, time) = match text.split_once(['T', ' ']) {
            Some((date, time)) => (Some(date), time),
            None => (None, text),
        };
        let (time, offset_s) = zone(time)?;
        let mut parts = time.split(':');
        let (hours, minutes, rest) = (parts.next()?, parts.next()?, parts.next()?);
        let (whole, fraction) = rest.split_once('.').unwrap_or((rest, ""));
        let [hours, minutes, whole] = [number(hours, 23)?, number(minutes, 59)?, number(whole, 60)?];
        let fraction = if fraction.is_empty() { 0.0 } else { format!("0.{fraction}").parse::<f64>().ok()? };
        if parts.next().is_some() {
            return None;
        }
        let days = match date {
            Some(date) => days(date)?,
            None => 0,
        };
        let seconds = days * DAY_S + hours * 3600 + minutes * 60 + whole - offset_s;
        Some(Self { seconds, fraction, of_day: date.is_none() })
    }

    /// Seconds since another stamp; a time of day more than half a day earlier is of the next day.
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // years in seconds
    pub fn since(self, first: Self) -> f64 {
        let mut seconds = self.seconds - first.seconds;
        if self.of_day && seconds < -DAY_S / 2 {
            seconds += DAY_S;
        }
        seconds as f64 + (self.fraction - first.fraction)
    }
}

/// The time without its zone, and the offset of the zone [s].
fn zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(place) = time.rfind(['+', '-']) else { return Some((time, 0)) };
    let (hours, minutes) = time[place + 1..].split_once(':').unwrap_or((&time[place + 1..], "0"));
    let offset = number(hours, 14)? * 3600 + number(minutes, 59)? * 60;
    Some((&time[..place], if time[place..].starts_with('-') { -offset } else { offset }))
}

fn number(text: &str, greatest: i64) -> Option<i64> {
    let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    digits.then(|| text.parse().ok()).flatten().filter(|value| *value <= greatest)
}

/// Days since 1970-01-01 in the Gregorian calendar (H. Hinnant, "chrono-compatible low-level date algorithms", `days_from_civil`).
fn days(date: &str) -> Option<i64> {
    let mut parts = date.split(['-', '/']);
    let [year, month, day] = [number(parts.next()?, 9999)?, number(parts.next()?, 12)?, number(parts.next()?, 31)?];
    if parts.next().is_some() || month == 0 || day == 0 || year < 1900 {
        return None;
    }
    let year = if month <= 2 { year - 1 } else { year };
    let of_era = year.rem_euclid(400);
    let of_year = (153 * (if month > 2 { month - 3 } else { month + 9 }) + 2) / 5 + day - 1;
    let day_of_era = of_era * 365 + of_era / 4 - of_era / 100 + of_year;
    Some(year.div_euclid(400) * 146_097 + day_of_era - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(first: &str, second: &str) -> f64 {
        TimeStamp::parse(second).unwrap().since(TimeStamp::parse(first).unwrap())
    }

    #[test]
    fn differences_of_stamps_are_exact_to_the_microsecond() {
        assert!((between("12:34:56.789", "12:34:57.790") - 1.001).abs() < 1e-12);
        assert_eq!(between("23:59:59.5", "00:00:00.5"), 1.0);
        assert_eq!(between("1970-01-01T00:00:00Z", "2000-03-01T00:00:00Z"), 951_868_800.0); // `date -d 2000-03-01Z +%s`
        assert_eq!(between("2024-02-28 23:00:00", "2024-03-01 00:00:00"), 90_000.0); // a leap year
        assert_eq!(between("2026-01-01T12:00:00+01:00", "2026-01-01T11:00:00Z"), 0.0);
    }

    #[test]
    fn numbers_and_words_are_no_stamps() {
        for text in ["0.5", "12:30", "time", "25:00:00", "2026-13-01T00:00:00", "1:2:3:4", ""] {
            assert_eq!(TimeStamp::parse(text), None, "{text}");
        }
    }
}
