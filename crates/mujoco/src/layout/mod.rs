//! Where MuJoCo's structs hold what no function returns, for every version we know.

mod row;
mod table;

pub(crate) use row::{Field, Layout};

/// The row of the version that `mj_version()` says; the table describes 64-bit machines.
pub(crate) fn find(version: i32) -> Option<Layout> {
    let known = if cfg!(target_pointer_width = "64") { &table::KNOWN[..] } else { &[] };
    known.iter().find(|l| l.version == version).copied()
}

/// Every version there is a row for, such as `3.3.7, 3.17.0, 4.0.0`.
pub(crate) fn known_versions() -> String {
    table::KNOWN.map(|l| release(l.version)).join(", ")
}

/// `mj_version()` as the version is written: one decimal digit a part up to 3.3, three digits since.
pub(crate) fn release(version: i32) -> String {
    let part = |unit: i32, digits: i32| version / unit % digits;
    if version < 1000 {
        format!("{}.{}.{}", part(100, 10), part(10, 10), part(1, 10))
    } else {
        format!("{}.{}.{}", part(1_000_000, 1000), part(1000, 1000), part(1, 1000))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_written_as_they_are_released() {
        assert_eq!([337, 3_017_000, 4_000_000].map(release), ["3.3.7", "3.17.0", "4.0.0"]);
        assert_eq!(known_versions(), "3.3.7, 3.17.0, 4.0.0");
    }

    #[test]
    fn only_versions_with_a_row_are_known() {
        for version in [337, 3_017_000, 4_000_000] {
            assert_eq!(find(version).map(|l| l.version), Some(version));
        }
        for version in [0, 338, 3_016_000, 5_000_000, -1] {
            assert_eq!(find(version), None);
        }
    }
}
