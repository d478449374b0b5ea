//! How late the cycles of a robot that drives began.

/// Delays of cycles' starts, ms. NaN while there are none.
#[derive(Clone, Copy, Debug)]
pub struct Late([f64; 4]);

impl Default for Late {
    fn default() -> Self {
        Self([f64::NAN; 4])
    }
}

impl PartialEq for Late {
    fn eq(&self, other: &Self) -> bool {
        self.0.map(f64::to_bits) == other.0.map(f64::to_bits)
    }
}

impl Late {
    /// Minimum, median, 99th percentile, and maximum.
    pub fn of(quantiles: [f64; 4]) -> Self {
        Self(quantiles)
    }

    /// Of cycles that were so late.
    pub fn of_all(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        let Some(last) = all.len().checked_sub(1) else {
            return Self::default();
        };
        let at = |share: f64| all[(share * last as f64).ceil() as usize];
        Self([at(0.0), at(0.5), at(0.99), at(1.0)])
    }

    /// Minimum, median, 99th percentile, and maximum, ms.
    pub fn quantiles(self) -> [f64; 4] {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_sorted_times() {
        let times = (0..=100).rev().map(f64::from).collect();
        assert_eq!(Late::of_all(times).quantiles(), [0.0, 50.0, 99.0, 100.0]);
        assert_eq!(Late::of_all(vec![7.5]).quantiles(), [7.5; 4]);
        assert!(Late::of_all(Vec::new()).quantiles()[0].is_nan());
    }
}
