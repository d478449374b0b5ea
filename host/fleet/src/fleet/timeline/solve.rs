//! Linear least squares with few unknowns in each equation, by conjugate gradients on the normal equations (Hestenes and Stiefel,
//! 1952).

/// How far two clocks are apart, by a pair of messages.
pub(super) struct Equation {
    pub(super) terms: [Term; 2],
    /// Sum of the terms: the signed corrections of clocks at given times, ms.
    pub(super) value: f64,
    /// Standard deviation that the value is given, ms.
    pub(super) error: f64,
    /// Maximum error of the value, ms.
    pub(super) bound: f64,
}

/// A clock in an equation.
pub(super) struct Term {
    pub(super) clock: usize,
    pub(super) sign: f64,
    /// Its own time, ms.
    pub(super) at: f64,
}

/// Coefficients by unknown, and what they should add up to.
pub(super) type Row = (Vec<(usize, f64)>, f64);

/// The unknowns that minimise the sum of squares of all rows' errors. Unknowns that no row contains stay 0.
pub(super) fn solve_least_squares(unknowns: usize, rows: &[Row]) -> Vec<f64> {
    /// Without rounding, the solution is exact after as many steps as there are unknowns.
    const ROUNDS: usize = 20;
    /// The remaining fraction of the gradient at the end.
    const LEFT: f64 = 1e-13;
    let product = |(coefficients, _): &Row, of: &[f64]| -> f64 {
        coefficients
            .iter()
            .map(|&(unknown, coefficient)| coefficient * of[unknown])
            .sum()
    };
    // The transpose, of a value for each row.
    let gathered = |value: &dyn Fn(&Row) -> f64| {
        let mut sums = vec![0.0; unknowns];
        for row in rows {
            let value = value(row);
            for &(unknown, coefficient) in &row.0 {
                sums[unknown] += coefficient * value;
            }
        }
        sums
    };
    // Each unknown in the unit in which its column has length 1.
    let mut scales = vec![0.0; unknowns];
    for &(unknown, coefficient) in rows.iter().flat_map(|(coefficients, _)| coefficients) {
        scales[unknown] += coefficient * coefficient;
    }
    let scaled = |vector: &[f64]| -> Vec<f64> {
        let of = |(value, scale): (&f64, &f64)| if *scale > 0.0 { value / scale } else { 0.0 };
        vector.iter().zip(&scales).map(of).collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let add = |to: &mut [f64], share: f64, of: &[f64]| {
        for (element, other) in to.iter_mut().zip(of) {
            *element += share * other;
        }
    };
    let mut solution = vec![0.0; unknowns];
    let mut gradient = gathered(&|row| row.1);
    let mut direction = scaled(&gradient);
    let mut size = dot(&gradient, &direction);
    let enough = LEFT * LEFT * size;
    for _ in 0..ROUNDS * unknowns {
        if size <= enough || size == 0.0 {
            break;
        }
        let curved = gathered(&|row| product(row, &direction));
        let step = size / dot(&direction, &curved);
        add(&mut solution, step, &direction);
        add(&mut gradient, -step, &curved);
        let mut next = scaled(&gradient);
        let new = dot(&gradient, &next);
        add(&mut next, new / size, &direction);
        (direction, size) = (next, new);
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::solve_least_squares;

    /// A line through points that scatter around it: intercept and slope of the textbook's formula.
    #[test]
    fn a_line_is_fitted() {
        let points = [(0.0, 1.1), (1.0, 2.9), (2.0, 5.2), (3.0, 6.8)];
        let rows: Vec<_> = points.iter().map(|&(x, y)| (vec![(0, 1.0), (1, x)], y)).collect();
        let [intercept, slope] = solve_least_squares(2, &rows)[..] else {
            panic!("two unknowns")
        };
        assert!((slope - 1.94).abs() < 1e-9, "{slope}");
        assert!((intercept - 1.09).abs() < 1e-9, "{intercept}");
    }

    /// A chain of a thousand unknowns, each one more than the last.
    #[test]
    fn long_chains_are_solved_and_what_nothing_says_stays_0() {
        let mut rows = vec![(vec![(0, 1.0)], 1.0)];
        rows.extend((1..1000).map(|at| (vec![(at, 1.0), (at - 1, -1.0)], 1.0)));
        let solution = solve_least_squares(1001, &rows);
        for (at, value) in solution[..1000].iter().enumerate() {
            assert!((value - (at + 1) as f64).abs() < 1e-4, "{at}: {value}");
        }
        assert_eq!(solution[1000], 0.0);
    }
}
