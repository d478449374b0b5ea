//! The readings of an e-puck's sensors, as its behaviours have them and as its converters give them.
//!
//! The converters have 12 bits. Sensors are numbered clockwise from the front right: 17, 50, 90 and 150 degrees to the right, then 150,
//! 90, 50 and 17 to the left. A proximity sensor reads the more, the nearer something is, and a light sensor the less, the brighter it is.

/// The maximum reading.
const GREATEST: f64 = 4095.0;
/// Sensors of each kind.
const SENSORS: usize = 8;
/// Sensors of proximity that behaviours use: 17 and 50 degrees to the left, then 50 and 17 to the right.
const NEAR: [usize; 4] = [7, 6, 1, 0];
/// Sensors of light in the behaviours' order: 17 and 50 degrees to the left, 50 and 17 to the right, 90 and 150 to the left, 150 and 90
/// to the right.
const LIGHT: [usize; SENSORS] = [7, 6, 1, 0, 5, 4, 3, 2];

pub(crate) use oneiro::acting::Readings as Activations;

#[cfg(any(test, feature = "twin"))]
/// What a robot reads: eight sensors of proximity, then eight of light, 0 to 4095.
pub(crate) type Raw = [u16; 2 * SENSORS];

/// The activations that a robot's readings give: those of proximity first, then those of light, as the driver has them.
///
/// # Errors
/// There are not 16, or one is not from 0 to 4095.
pub(crate) fn activations(readings: &[f64]) -> Result<Activations, String> {
    let is_reading = |reading: &f64| (0.0..=GREATEST).contains(reading);
    if readings.len() != 2 * SENSORS || !readings.iter().all(is_reading) {
        return Err(format!(
            "the e-puck's readings are {readings:?}; allowed: 16 numbers from 0 to {GREATEST}"
        ));
    }
    let (near, light) = readings.split_at(SENSORS);
    Ok(Activations {
        near: NEAR.map(|sensor| (near[sensor] / GREATEST) as f32),
        light: LIGHT.map(|sensor| (1.0 - light[sensor] / GREATEST) as f32),
    })
}

#[cfg(any(test, feature = "twin"))]
/// The nearest readings of a robot whose activations would be these. Its sensors of proximity that no behaviour uses read 0.
pub(crate) fn readings(activations: &Activations) -> Raw {
    let raw = |share: f64| (GREATEST * share.clamp(0.0, 1.0)).round() as u16;
    let mut readings = [0; 2 * SENSORS];
    for (sensor, near) in NEAR.into_iter().zip(activations.near) {
        readings[sensor] = raw(f64::from(near));
    }
    for (sensor, light) in LIGHT.into_iter().zip(activations.light) {
        readings[SENSORS + sensor] = raw(1.0 - f64::from(light));
    }
    readings
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bearings of ps0 to ps7 by the vendor's numbering, degrees counter-clockwise, and those of the behaviours' sensors by
    /// `shaders/wgsl/sensor/foraging.wgsl`.
    const BEARINGS: [i32; SENSORS] = [-17, -50, -90, -150, 150, 90, 50, 17];
    const BEHAVIOURS: [i32; SENSORS] = [17, 50, -50, -17, 90, 150, -150, -90];

    #[test]
    fn sensors_keep_their_bearings() {
        for (index, bearing) in BEHAVIOURS.into_iter().enumerate() {
            let sensor = BEARINGS.iter().position(|of_sensor| *of_sensor == bearing).unwrap();
            let mut raw = [0.0; 16];
            raw[8..].fill(4095.0);
            raw[sensor] = 4095.0;
            raw[8 + sensor] = 0.0;
            let found = activations(&raw).unwrap();
            for other in 0..SENSORS {
                let expected = if other == index { 1.0 } else { 0.0 };
                assert_eq!(found.light[other], expected, "{bearing}");
                if other < NEAR.len() {
                    assert_eq!(found.near[other], expected, "{bearing}");
                }
            }
        }
    }

    #[test]
    fn every_reading_comes_back() {
        for raw in 0..=4095_u16 {
            let mut all = [0; 16];
            all.iter_mut()
                .enumerate()
                .for_each(|(index, reading)| *reading = (raw + 256 * index as u16) % 4096);
            all[2..6].fill(0);
            assert_eq!(readings(&activations(&all.map(f64::from)).unwrap()), all);
        }
    }

    #[test]
    fn what_is_no_reading_is_refused() {
        for bad in [-1.0, 4095.5, f64::NAN, f64::INFINITY] {
            let mut all = [0.0; 16];
            all[9] = bad;
            assert!(activations(&all).unwrap_err().contains("0 to 4095"));
        }
        assert!(activations(&[0.0; 8]).unwrap_err().contains("16 numbers"));
    }
}
