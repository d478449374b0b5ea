// Trace details of a robot with eight sampled proximity sensors.

struct Details {
    // activations as perceived
    sensor_0: f32,
    sensor_1: f32,
    sensor_2: f32,
    sensor_3: f32,
    sensor_4: f32,
    sensor_5: f32,
    sensor_6: f32,
    sensor_7: f32,
    // the same before sensor noise
    real_0: f32,
    real_1: f32,
    real_2: f32,
    real_3: f32,
    real_4: f32,
    real_5: f32,
    real_6: f32,
    real_7: f32,
}

fn details(after: EpisodeState, real: Readings, perceived: Readings) -> Details {
    return Details(
        perceived.first.x, perceived.first.y, perceived.first.z, perceived.first.w,
        perceived.last.x, perceived.last.y, perceived.last.z, perceived.last.w,
        real.first.x, real.first.y, real.first.z, real.first.w,
        real.last.x, real.last.y, real.last.z, real.last.w,
    );
}

fn details_kept(values: Details) -> Details {
    return Details(
        stored(values.sensor_0), stored(values.sensor_1), stored(values.sensor_2), stored(values.sensor_3),
        stored(values.sensor_4), stored(values.sensor_5), stored(values.sensor_6), stored(values.sensor_7),
        stored(values.real_0), stored(values.real_1), stored(values.real_2), stored(values.real_3),
        stored(values.real_4), stored(values.real_5), stored(values.real_6), stored(values.real_7),
    );
}
