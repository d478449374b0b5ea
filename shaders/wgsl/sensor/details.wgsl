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

fn details(own: State, real: Readings, perceived: Readings) -> Details {
    return Details(
        perceived.first.x, perceived.first.y, perceived.first.z, perceived.first.w,
        perceived.last.x, perceived.last.y, perceived.last.z, perceived.last.w,
        real.first.x, real.first.y, real.first.z, real.first.w,
        real.last.x, real.last.y, real.last.z, real.last.w,
    );
}

fn details_kept(own: Details) -> Details {
    return Details(
        stored(own.sensor_0), stored(own.sensor_1), stored(own.sensor_2), stored(own.sensor_3),
        stored(own.sensor_4), stored(own.sensor_5), stored(own.sensor_6), stored(own.sensor_7),
        stored(own.real_0), stored(own.real_1), stored(own.real_2), stored(own.real_3),
        stored(own.real_4), stored(own.real_5), stored(own.real_6), stored(own.real_7),
    );
}
