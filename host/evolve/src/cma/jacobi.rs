//! Axes of a symmetric matrix by Jacobi's rotations in a fixed order (Golub and Van Loan, "Matrix computations", 4th edition,
//! 8.5): only additions, products, quotients and square roots, so every processor finds the same bits.

/// The eigenvalues of a symmetric matrix, row after row, and its eigenvectors: one in each column, row after row.
pub(super) fn axes(matrix: &[f64], size: usize) -> (Vec<f64>, Vec<f64>) {
    /// Six to ten sweeps suffice for matrices of this size; more only for what is no number.
    const SWEEPS: usize = 60;
    /// Squares of elements below this share of their diagonal's change no bit of it.
    const NEGLIGIBLE: f64 = 1e-36;
    let mut a = matrix.to_vec();
    // Row by row, so that rotations run over neighbours: the transpose of what is returned.
    let mut vectors = vec![0.0; size * size];
    for index in 0..size {
        vectors[index * size + index] = 1.0;
    }
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..size {
            for q in p + 1..size {
                let off = a[p * size + q];
                let (one, other) = (a[p * size + p], a[q * size + q]);
                if off * off <= NEGLIGIBLE * (one * other).abs() {
                    continue;
                }
                is_diagonal = false;
                let theta = (other - one) / (2.0 * off);
                let size_of = 1.0 / (theta.abs() + (theta * theta + 1.0).sqrt());
                let tangent = if theta < 0.0 { -size_of } else { size_of };
                let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
                let sine = tangent * cosine;
                for row in 0..size {
                    let [first, second] = [a[row * size + p], a[row * size + q]];
                    a[row * size + p] = cosine * first - sine * second;
                    a[row * size + q] = sine * first + cosine * second;
                }
                rotate(&mut a, size, [p, q], [cosine, sine]);
                rotate(&mut vectors, size, [p, q], [cosine, sine]);
                (a[p * size + q], a[q * size + p]) = (0.0, 0.0);
            }
        }
        if is_diagonal {
            break;
        }
    }
    let values = (0..size).map(|index| a[index * size + index]).collect();
    let columns = (0..size * size).map(|index| vectors[index % size * size + index / size]);
    (values, columns.collect())
}

/// Rotates two rows.
fn rotate(matrix: &mut [f64], size: usize, [p, q]: [usize; 2], [cosine, sine]: [f64; 2]) {
    let (before, after) = matrix.split_at_mut(q * size);
    let rows = before[p * size..][..size].iter_mut().zip(&mut after[..size]);
    for (first, second) in rows {
        (*first, *second) = (cosine * *first - sine * *second, sine * *first + cosine * *second);
    }
}

#[cfg(test)]
mod tests {
    use rand::distr::Distribution;

    use super::*;
    use crate::random::{Normal, Stream, stream};

    /// A matrix is that of its axes again, and these are at right angles and of length 1.
    #[test]
    fn axes_make_the_matrix_again() {
        let mut random = stream(1, Stream::Sampling, 0);
        let normal = Normal { deviation: 1.0 };
        for size in [1, 2, 3, 10, 40] {
            let root: Vec<f64> = (0..size * size).map(|_| normal.sample(&mut random)).collect();
            // Of which the axes' lengths differ by a factor of a million.
            let scale = |row: usize| 10.0_f64.powf(-6.0 * row as f64 / size as f64);
            let product = |a: &dyn Fn(usize, usize) -> f64, row, column| -> f64 {
                (0..size).map(|k| a(row, k) * a(column, k)).sum()
            };
            let matrix: Vec<f64> = (0..size * size)
                .map(|index| product(&|row, k| root[row * size + k] * scale(k), index / size, index % size))
                .collect();
            let (values, vectors) = axes(&matrix, size);
            let greatest = matrix.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            for (index, expected) in matrix.iter().enumerate() {
                let (row, column) = (index / size, index % size);
                let again: f64 = (0..size)
                    .map(|k| vectors[row * size + k] * values[k] * vectors[column * size + k])
                    .sum();
                assert!(
                    (again - expected).abs() < 1e-13 * greatest,
                    "{size}: {again} {expected}"
                );
                let right = product(&|row, k| vectors[row * size + k], row, column);
                let expected = if row == column { 1.0 } else { 0.0 };
                assert!((right - expected).abs() < 1e-13, "{size}: {right}");
            }
            assert!(values.iter().all(|value| *value > 0.0), "{values:?}");
        }
    }
}
