//! Which of many settings are worth a look: those that none other beats at everything.

/// The numbers of the points on the Pareto front, the cheapest first. Of both values less is better.
///
/// A point is on it if no other is as good at one of them and better at the other; of equal points it is the first.
///
/// ```
/// use antumbra::measure::pareto_front;
///
/// // Cost and error: the third costs more than the second, and errs as often.
/// assert_eq!(pareto_front(&[(3.0, 0.0), (1.0, 2.0), (2.0, 2.0)]), [1, 0]);
/// ```
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    // Stable: equal points stay in their order.
    order.sort_by(|&a, &b| {
        let (a, b) = (points[a], points[b]);
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let is_better = points[i].1 < least;
        least = least.min(points[i].1);
        is_better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_what_nothing_beats() {
        let points = [
            (5.0, 1.0),
            (1.0, 9.0),
            (2.0, 9.0), // slower than the second, and no better
            (3.0, 4.0),
            (3.0, 5.0), // as slow as the fourth, and worse
            (4.0, 4.5), // worse at both than the fourth
            (5.0, 1.0), // the first once more
            (9.0, 0.0),
        ];
        assert_eq!(pareto_front(&points), [1, 3, 0, 7]);
    }

    #[test]
    fn one_that_is_best_at_both_is_alone() {
        assert_eq!(pareto_front(&[(2.0, 2.0), (1.0, 0.0), (1.5, 0.0)]), [1]);
        assert_eq!(pareto_front(&[]), [0; 0]);
    }
}
