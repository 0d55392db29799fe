//! Seeds of a comparison.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Seeds as ranges, such as `0-9,100-199`; `10` alone is the first ten.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Seeds(Vec<RangeInclusive<u64>>);

/// Seeds of one comparison.
const MOST: u64 = 10_000;

impl Seeds {
    /// Seeds 0 to `count` − 1.
    #[must_use]
    pub fn first(count: u64) -> Self {
        Self::of(if count == 0 { Vec::new() } else { vec![0..=count - 1] })
    }

    /// The one seed `seed`.
    #[must_use]
    pub fn one(seed: u64) -> Self {
        Self(vec![seed..=seed])
    }

    /// Those of both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self::of(self.0.iter().chain(&other.0).cloned().collect())
    }

    /// All of them, from the lowest.
    pub fn iter(&self) -> impl Iterator<Item = u64> {
        self.0.iter().cloned().flatten()
    }

    /// How many.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.iter().fold(0, |sum: usize, range| sum.saturating_add(length(range) as usize))
    }

    /// `ranges` in order, joined where they touch.
    fn of(mut ranges: Vec<RangeInclusive<u64>>) -> Self {
        ranges.sort_by_key(|range| *range.start());
        let mut joined: Vec<RangeInclusive<u64>> = Vec::new();
        for range in ranges {
            match joined.last_mut() {
                Some(last) if *range.start() <= last.end().saturating_add(1) => {
                    *last = *last.start()..=*last.end().max(range.end());
                }
                _ => joined.push(range),
            }
        }
        Self(joined)
    }
}

fn length(range: &RangeInclusive<u64>) -> u64 {
    (range.end() - range.start()).saturating_add(1)
}

impl fmt::Display for Seeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [range] = &self.0[..]
            && *range.start() == 0
        {
            return write!(f, "{}", length(range));
        }
        let ranges: Vec<String> = self.0.iter().map(|range| format!("{}-{}", range.start(), range.end())).collect();
        f.write_str(&ranges.join(","))
    }
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u64>().map_err(|_| format!("`{}` is not a seed", text.trim()));
        if let Ok(count) = number(text) {
            return if (1..=MOST).contains(&count) {
                Ok(Self::first(count))
            } else {
                Err(format!("a number of seeds is between 1 and {MOST}, got {count}"))
            };
        }
        let range = |part: &str| match part.split_once('-') {
            None => number(part).map(|seed| seed..=seed),
            Some((low, high)) => match (number(low)?, number(high)?) {
                (low, high) if low <= high => Ok(low..=high),
                (low, high) => Err(format!("`{low}-{high}` is a descending range; write {high}-{low}")),
            },
        };
        let seeds = Self::of(text.split(',').map(range).collect::<Result<_, _>>()?);
        match seeds.count() {
            count if count as u64 <= MOST => Ok(seeds),
            count => Err(format!("{count} seeds are more than {MOST}")),
        }
    }
}

impl Serialize for Seeds {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Seeds {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_counts_or_ranges_and_the_same_again_as_text() {
        for (text, count, again) in [
            ("3", 3, "3"),
            ("0-9, 100-199", 110, "0-9,100-199"),
            ("7-7", 1, "7-7"),
            ("5,1,2-4,3", 5, "1-5"),
            ("0-1,2", 3, "3"),
        ] {
            let seeds: Seeds = text.parse().unwrap();
            assert_eq!((seeds.count(), seeds.to_string().as_str()), (count, again));
            assert_eq!(seeds.to_string().parse(), Ok(seeds));
        }
        assert_eq!("1,4-5".parse::<Seeds>().unwrap().iter().collect::<Vec<_>>(), [1, 4, 5]);
        assert_eq!(Seeds::first(2).union(&Seeds::one(2)), Seeds::first(3));
        assert_eq!(Seeds::one(4).union(&Seeds::one(2)).to_string(), "2-2,4-4");
        for (text, says) in [
            ("0", "between 1 and 10000, got 0"),
            ("9-3", "`9-3` is a descending range; write 3-9"),
            ("0-99999", "100000 seeds are more than 10000"),
            ("0-18446744073709551615", "more than 10000"),
            ("a", "`a` is not a seed"),
            ("1,", "`` is not a seed"),
        ] {
            let refusal = text.parse::<Seeds>().unwrap_err();
            assert!(refusal.contains(says), "{text}: {refusal}");
        }
    }
}
