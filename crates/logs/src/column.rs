//! What a column is called.

/// A column as the header names it: `th`, or `th [rad]` with its unit, or `th_deg`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: String,
}

impl Column {
    pub(crate) fn new(header: &str) -> Self {
        let in_brackets = header.strip_suffix(']').and_then(|h| h.rsplit_once('['));
        // `speed (m/s)` has a unit, `cos(th)` has none.
        let in_parentheses = header.strip_suffix(')').and_then(|h| h.rsplit_once('('));
        let parted = in_parentheses.filter(|(name, unit)| name.ends_with(char::is_whitespace) || unit.contains('/'));
        match in_brackets.or(parted) {
            Some((name, unit)) if !name.trim().is_empty() => {
                Self { name: name.trim().to_owned(), unit: unit.trim().to_owned() }
            }
            _ => Self { name: header.to_owned(), unit: named(header).into() },
        }
    }
}

/// The unit of an angle or its rate in degrees, or of a speed in revolutions, that the end of a column's name tells: `roll_deg`, `gyro_dps`, `motor_rpm`. None of one that is called a temperature.
fn named(column: &str) -> &'static str {
    const NAMED: [(&str, &str); 9] = [
        ("_deg", "deg"),
        ("_degs", "deg"),
        ("_degrees", "deg"),
        ("_deg_s", "deg/s"),
        ("_degps", "deg/s"),
        ("_deg_per_s", "deg/s"),
        ("_dps", "deg/s"),
        ("_rpm", "rpm"),
        ("_rps", "rev/s"),
    ];
    let name = column.to_lowercase();
    let of = NAMED.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)));
    let is_temperature = |stem: &str| stem.split('_').any(|word| word == "t" || word.starts_with("temp"));
    of.filter(|(stem, _)| !is_temperature(stem)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_with_units() {
        for (name, unit) in [
            ("roll_deg", "deg"),
            ("tilt_deg", "deg"),
            ("Gyro_DPS", "deg/s"),
            ("motor_rpm", "rpm"),
            ("temp_deg", ""),
            ("oven_temperature_deg", ""),
            ("deg", ""),
            ("sol_rad", ""),
        ] {
            assert_eq!(named(name), unit, "{name}");
        }
    }
}
