//! Cases side by side, and what was done before.

use std::path::Path;
use std::sync::Mutex;
use std::{fs, thread};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sindyna_record::{json, save};

use super::record::{Result, root};

/// `run` of every case, `jobs` at a time, in the order of the cases.
///
/// # Errors
/// The first error of a run; no other case is begun then.
pub fn each<C: Sync, T: Send>(jobs: usize, cases: &[C], run: impl Fn(&C) -> Result<T> + Sync) -> Result<Vec<T>> {
    let next = Mutex::new(cases.iter().enumerate());
    let done = Mutex::new(Vec::with_capacity(cases.len()));
    let take = || next.lock().ok()?.next();
    let work = || {
        while let Some((i, case)) = take() {
            let found = run(case);
            let failed = found.is_err();
            if let Ok(mut done) = done.lock() {
                done.push((i, found));
            }
            if failed {
                // Who takes the next finds none.
                next.lock().iter_mut().for_each(|left| left.by_ref().for_each(drop));
            }
        }
    };
    thread::scope(|scope| (0..jobs.max(1)).for_each(|_| drop(scope.spawn(work))));
    let mut done = done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, found)| found).collect()
}

/// What was measured before, from `runs/PATH`, or else what `measure` says, which is kept there. Whoever changes what is measured deletes the folder.
///
/// # Errors
/// Of measuring, or of writing.
pub fn kept<T: Serialize + DeserializeOwned>(path: impl AsRef<Path>, measure: impl FnOnce() -> Result<T>) -> Result<T> {
    let path = root().join("runs").join(path);
    if let Some(found) = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
        return Ok(found);
    }
    let found = measure()?;
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    save(&path, &json(&found)?)?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_cases_and_the_first_error_ends_all() {
        let cases: Vec<u64> = (0..50).collect();
        let found = each(4, &cases, |n| Ok(n * n)).unwrap();
        assert_eq!(found, cases.iter().map(|n| n * n).collect::<Vec<_>>());
        let error = each(1, &cases, |n| if *n < 3 { Ok(*n) } else { anyhow::bail!("no {n}") }).unwrap_err();
        assert_eq!(error.to_string(), "no 3");
    }
}
