//! Fewer points that look the same.

/// A point of a drawing.
pub(crate) type Point = (f64, f64);

/// At most `most` of `points`, which follow each other from left to right: the lowest and the highest of each stretch.
pub(crate) fn thinned(points: &[Point], most: usize) -> Vec<Point> {
    if points.len() <= most || most < 4 {
        return points.to_vec();
    }
    let stretch = points.len().div_ceil(most / 2);
    let mut kept = Vec::with_capacity(most);
    for part in points.chunks(stretch) {
        let by = |a: &&(usize, Point), b: &&(usize, Point)| a.1.1.total_cmp(&b.1.1);
        let numbered: Vec<(usize, Point)> = part.iter().copied().enumerate().collect();
        let (Some(low), Some(high)) = (numbered.iter().min_by(by), numbered.iter().max_by(by)) else { continue };
        let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        kept.push(first.1);
        if first.0 != second.0 {
            kept.push(second.1);
        }
    }
    kept
}

/// `points` without those that lie within `tolerance` of the straight line between the ones that are kept (Ramer 1972; Douglas, Peucker 1973).
pub(crate) fn simplified(points: &[Point], tolerance: f64) -> Vec<Point> {
    let mut kept = vec![false; points.len()];
    let mut open = vec![(0, points.len().saturating_sub(1))];
    while let Some((first, last)) = open.pop() {
        if last >= points.len() {
            continue;
        }
        (kept[first], kept[last]) = (true, true);
        let away = |i: &usize| distance(points[*i], points[first], points[last]);
        let farthest = (first + 1..last).max_by(|a, b| away(a).total_cmp(&away(b)));
        if let Some(middle) = farthest.filter(|i| away(i) > tolerance) {
            open.extend([(first, middle), (middle, last)]);
        }
    }
    points.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// From `point` to the stretch between `a` and `b`.
fn distance(point: Point, a: Point, b: Point) -> f64 {
    let (along, to) = ((b.0 - a.0, b.1 - a.1), (point.0 - a.0, point.1 - a.1));
    let square = along.0.powi(2) + along.1.powi(2);
    let share = if square > 0.0 { ((along.0 * to.0 + along.1 * to.1) / square).clamp(0.0, 1.0) } else { 0.0 };
    (to.0 - share * along.0).hypot(to.1 - share * along.1)
}

/// At most `most` of `items`, evenly spread.
pub(crate) fn spread<T: Copy>(items: &[T], most: usize) -> Vec<T> {
    items.iter().copied().step_by(items.len().div_ceil(most.max(1)).max(1)).collect()
}

/// Lowest and highest of `values`, those that are no number of any use left out; `None` if there are none.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let usable = values.filter(|v| v.abs() < 1e100);
    usable.fold(None, |range, v| Some(range.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simplified_line_is_nowhere_farther_away_than_allowed() {
        let circle: Vec<Point> =
            (0..=400).map(|i| f64::from(i) / 63.0).map(|a| (100.0 * a.cos(), 100.0 * a.sin())).collect();
        let kept = simplified(&circle, 0.1);
        // A chord of the angle a is 100 (1 − cos a/2) away from its arc: for 0.1 that is 0.089, so 71 chords go round.
        assert!((71..=160).contains(&kept.len()), "{}", kept.len());
        let near = |p: &Point| kept.windows(2).map(|ends| distance(*p, ends[0], ends[1])).fold(f64::INFINITY, f64::min);
        assert!(circle.iter().all(|p| near(p) <= 0.1));
        assert_eq!((kept.first(), kept.last()), (circle.first(), circle.last()));
        assert_eq!(simplified(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 5.0)], 0.1).len(), 3);
        assert_eq!(simplified(&[], 0.1), []);
    }

    #[test]
    fn peaks_are_kept() {
        let mut points: Vec<Point> = (0..10_000).map(|i| (f64::from(i), 0.0)).collect();
        points[4_321].1 = 7.0;
        points[4_322].1 = -7.0;
        let kept = thinned(&points, 100);
        assert!(kept.len() <= 100 && kept.contains(&(4_321.0, 7.0)) && kept.contains(&(4_322.0, -7.0)));
        assert!(kept.is_sorted_by_key(|p| p.0));
        assert_eq!(spread(&[1, 2, 3, 4, 5], 2), [1, 4]);
        assert_eq!(range([f64::NAN, 2.0, f64::INFINITY, -1.0].into_iter()), Some((-1.0, 2.0)));
    }
}
