//! The order in which states that are rates of each other move.

/// The states that have a rate among the states, each after that rate: of x, v, a with ẋ = v, v̇ = a first v, then x. `rate` gives the rate
/// of a state, `None` where it has none.
///
/// # Errors
/// A state that is, by way of others, its own rate.
pub(crate) fn after_their_rates(n: usize, rate: impl Fn(usize) -> Option<usize>) -> Result<Vec<usize>, usize> {
    let mut pending: Vec<usize> = (0..n).filter(|&i| rate(i).is_some()).collect();
    let mut ordered = Vec::with_capacity(pending.len());
    while let Some(&first) = pending.first() {
        let waits = |i: &&usize| rate(**i).is_some_and(|r| pending.contains(&r));
        let (waiting, ready): (Vec<usize>, Vec<usize>) = pending.iter().partition(waits);
        if ready.is_empty() {
            return Err(first);
        }
        ordered.extend(ready);
        pending = waiting;
    }
    Ok(ordered)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_move_from_the_last_rate_to_the_first_and_circles_have_no_order() {
        let chain = [Some(1), Some(3), None, None];
        assert_eq!(after_their_rates(4, |i| chain[i]), Ok(vec![1, 0]));
        let circle = [Some(1), Some(0)];
        assert_eq!(after_their_rates(2, |i| circle[i]), Err(0));
    }
}
