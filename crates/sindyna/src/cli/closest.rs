//! The name that was meant.

use strsim::osa_distance;

/// The known name most like `given`, if one is alike enough to be a slip.
pub(crate) fn closest<'a>(given: &str, known: &[&'a str]) -> Option<&'a str> {
    let plain = |s: &str| s.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_lowercase();
    let distances = known.iter().map(|name| (osa_distance(&plain(given), &plain(name)), *name));
    distances.min().filter(|(distance, name)| *distance <= name.len() / 3).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_their_name() {
        let known = ["cart-pole", "mountain-car", "pendulum", "inverted-pendulum"];
        for (given, meant) in [
            ("cartpole", Some("cart-pole")),
            ("pendulm", Some("pendulum")),
            ("MountainCar", Some("mountain-car")),
            ("pendlum", Some("pendulum")),
            ("walker", None),
        ] {
            assert_eq!(closest(given, &known), meant, "{given}");
        }
        assert_eq!(
            closest("sidny", &["sindy", "sac", "lqr"]),
            Some("sindy"),
            "two letters in the wrong order are one slip"
        );
        assert_eq!(closest("sac", &["lqr", "mbpo"]), None);
    }
}
