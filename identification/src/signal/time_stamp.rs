//! Times of day and dates in the formats of loggers: `12:34:56.789`, `2026-01-02T12:34:56.789Z`, `2026-01-02 12:34:56+01:00`, `02.01.2026
//! 12:34:56,789`, `01/02/2026 12:34:56.789 PM`.
//!
//! Our own, since a crate for calendars and time zones would be larger than all code that reads records.

/// An instant as whole seconds and a fraction, so that differences over years keep their microseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeStamp {
    seconds: i64,
    fraction: f64,
    date: Date,
}

/// The date of a stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Date {
    /// None: midnight lies between 23:59:59 and 00:00:00.
    None,
    /// Days since 1970-01-01.
    Day(i64),
    /// Two numbers and a year: the date as day and month, and as month and day; `None` if invalid.
    OfEitherOrder([Option<i64>; 2]),
}

impl Date {
    /// Its day in either order.
    fn days(self) -> [Option<i64>; 2] {
        match self {
            Self::None => [Some(0); 2],
            Self::Day(day) => [Some(day); 2],
            Self::OfEitherOrder(days) => days,
        }
    }
}

/// Times since the first stamp of a file.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    first: Option<TimeStamp>,
    /// Whether all dates so far are valid in each order, and the first date in it.
    days: [Option<i64>; 2],
}

const DAY_S: i64 = 86_400;

impl TimeStamp {
    /// Reads a time stamp; `None` if the text is not one.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (text, half_day) = half_day(text.trim());
        let (date, time) = match text.split_once(['T', ' ']) {
            Some((date, time)) => (Some(date), time),
            None => (None, text),
        };
        let (time, offset_s) = zone(time)?;
        let mut parts = time.split(':');
        let (hours, minutes, rest) = (parts.next()?, parts.next()?, parts.next()?);
        let (whole, fraction) = rest.split_once(['.', ',']).unwrap_or((rest, ""));
        let [hours, minutes, whole] = [number(hours, 23)?, number(minutes, 59)?, number(whole, 60)?];
        let hours = match half_day {
            None => hours,
            Some(first_hour) if (1..=12).contains(&hours) => hours % 12 + first_hour,
            Some(_) => return None,
        };
        let fraction = if fraction.is_empty() { 0.0 } else { format!("0.{fraction}").parse::<f64>().ok()? };
        if parts.next().is_some() {
            return None;
        }
        let seconds = hours * 3600 + minutes * 60 + whole - offset_s;
        Some(Self { seconds, fraction, date: date.map_or(Some(Date::None), parse_date)? })
    }
}

impl Clock {
    /// Whether there was a first stamp.
    #[must_use]
    pub fn has_started(&self) -> bool {
        self.first.is_some()
    }

    /// Seconds since the first stamp; a time of day more than half a day earlier belongs to the next day. `None` if that depends on the
    /// order of day and month, which no date so far determines.
    #[allow(clippy::cast_precision_loss)] // years in seconds
    pub fn since_first(&mut self, stamp: TimeStamp) -> Option<f64> {
        let first = *self.first.get_or_insert_with(|| {
            self.days = stamp.date.days();
            stamp
        });
        let mut seconds = stamp.seconds - first.seconds;
        if stamp.date == Date::None && first.date == Date::None && seconds < -DAY_S / 2 {
            seconds += DAY_S;
        }
        if stamp.date != first.date {
            let days = stamp.date.days();
            for (first, day) in self.days.iter_mut().zip(days) {
                *first = first.filter(|_| day.is_some());
            }
            let since = |order: usize| Some(days[order]? - self.days[order]?);
            seconds += DAY_S
                * match [since(0), since(1)] {
                    [Some(days), None] | [None, Some(days)] => days,
                    [Some(days), Some(others)] if days == others => days,
                    _ => return None,
                };
        }
        Some(seconds as f64 + (stamp.fraction - first.fraction))
    }
}

/// A text without trailing AM or PM, and the first hour of that half of the day.
fn half_day(text: &str) -> (&str, Option<i64>) {
    let place = text.len().saturating_sub(2);
    match text.get(place..) {
        Some(mark) if mark.eq_ignore_ascii_case("am") => (text[..place].trim_end(), Some(0)),
        Some(mark) if mark.eq_ignore_ascii_case("pm") => (text[..place].trim_end(), Some(12)),
        _ => (text, None),
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

/// Year first, or day.month.year, or day and month in either order before the year.
fn parse_date(date: &str) -> Option<Date> {
    let mark = date.chars().find(|letter| !letter.is_ascii_digit())?;
    let mut parts = date.split(mark);
    let parts = [parts.next()?, parts.next()?, parts.next().filter(|_| parts.next().is_none())?];
    let day = |year: usize, month: usize, day: usize| days(parts[year], parts[month], parts[day]);
    match mark {
        '.' => Some(Date::Day(day(2, 1, 0)?)),
        '/' if parts[2].len() == 4 => {
            let days = [day(2, 1, 0), day(2, 0, 1)];
            days.iter().any(Option::is_some).then_some(Date::OfEitherOrder(days))
        }
        '-' | '/' => Some(Date::Day(day(0, 1, 2)?)),
        _ => None,
    }
}

/// Days since 1970-01-01 in the Gregorian calendar (H. Hinnant, "chrono-compatible low-level date algorithms", `days_from_civil`).
fn days(year: &str, month: &str, day: &str) -> Option<i64> {
    let [year, month, day] = [number(year, 9999)?, number(month, 12)?, number(day, 31)?];
    if month == 0 || day == 0 || year < 1900 {
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

    /// Seconds since the first stamp, for each.
    fn times(stamps: &[&str]) -> Vec<Option<f64>> {
        let mut clock = Clock::default();
        stamps.iter().map(|stamp| clock.since_first(TimeStamp::parse(stamp).unwrap())).collect()
    }

    fn between(first: &str, second: &str) -> f64 {
        times(&[first, second])[1].unwrap()
    }

    #[test]
    fn differences_of_stamps_are_exact_to_the_microsecond() {
        assert!((between("12:34:56.789", "12:34:57.790") - 1.001).abs() < 1e-12);
        assert_eq!(between("23:59:59.5", "00:00:00.5"), 1.0);
        assert_eq!(between("1970-01-01T00:00:00Z", "2000-03-01T00:00:00Z"), 951_868_800.0); // `date -d 2000-03-01Z +%s`
        assert_eq!(between("2024-02-28 23:00:00", "2024-03-01 00:00:00"), 90_000.0); // a leap year
        assert_eq!(between("2026/02/28 23:00:00", "2026/03/01 00:00:00"), 3600.0);
        assert_eq!(between("2026-01-01T12:00:00+01:00", "2026-01-01T11:00:00Z"), 0.0);
    }

    #[test]
    fn dates_with_dots_have_the_day_first() {
        assert_eq!(between("24.11.2026 12:00:00.25", "24.11.2026 12:00:00,75"), 0.5);
        assert_eq!(between("4.3.2026 23:59:59.5", "5.3.2026 00:00:00.5"), 1.0);
        assert_eq!(between("28.02.2026 23:00:00", "01.03.2026 00:00:00"), 3600.0);
    }

    #[test]
    fn dates_with_slashes_are_read_where_their_order_is_plain_or_does_not_matter() {
        assert_eq!(between("11/03/2026 12:00:00.25", "11/03/2026 12:00:00.75"), 0.5);
        assert_eq!(between("11/24/2026 23:59:59.5", "11/25/2026 00:00:00.5"), 1.0);
        assert_eq!(between("24/11/2026 23:59:59.5", "25/11/2026 00:00:00.5"), 1.0);
        // The second date determines the order of the first.
        assert_eq!(between("11/12/2026 23:59:59.5", "11/13/2026 00:00:00.5"), 1.0);
        assert_eq!(between("12/11/2026 23:59:59.5", "13/11/2026 00:00:00.5"), 1.0);
        let night = ["11/30/2026 23:59:59", "12/01/2026 00:00:00", "12/02/2026 00:00:00"];
        assert_eq!(times(&night), [Some(0.0), Some(1.0), Some(86_401.0)]);
        assert_eq!(times(&["11/03/2026 23:59:59.5", "11/04/2026 00:00:00.5"]), [Some(0.0), None]);
        assert_eq!(times(&["11/24/2026 23:59:59.5", "25/11/2026 00:00:00.5"]), [Some(0.0), None]);
    }

    #[test]
    fn halves_of_the_day_begin_at_twelve() {
        assert_eq!(between("11:59:59.5 AM", "12:00:00.5 PM"), 1.0);
        assert_eq!(between("12:59:59.5 pm", "1:00:00.5 pm"), 1.0);
        assert_eq!(between("12:00:00 AM", "1:00:00PM"), 13.0 * 3600.0);
        assert_eq!(between("11:59:59.5 PM", "12:00:00.5 AM"), 1.0);
        assert_eq!(between("11/24/2026 11:59:59.5 PM", "11/25/2026 12:00:00.5 AM"), 1.0);
        assert_eq!(between("11/24/2026 11:59:59.5 AM", "11/24/2026 12:00:00.5 PM"), 1.0);
    }

    #[test]
    fn numbers_and_words_are_no_stamps() {
        for text in [
            "0.5",
            "12:30",
            "time",
            "25:00:00",
            "2026-13-01T00:00:00",
            "1:2:3:4",
            "",
            "13:00:00 PM",
            "0:00:00 AM",
            "11.24.2026 12:00:00",
            "13/13/2026 12:00:00",
            "1/2/26 12:00:00",
            "1-2/2026 12:00:00",
            "PM",
            "\u{b5}m",
        ] {
            assert_eq!(TimeStamp::parse(text), None, "{text}");
        }
    }
}
