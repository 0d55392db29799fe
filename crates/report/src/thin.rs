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
