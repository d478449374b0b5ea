//! Sampled sensors: columns of tables.

use super::kind::{Counterpart, Entry, Feature, Scale};
use crate::genes::SENSORS;

pub(super) const ENTRY: Entry = Entry {
    keys: &["column"],
    features: &[Feature::Analogue, Feature::SeesLight, Feature::SeesNearness],
    numbers: |_, tables| [tables, 0.0],
    reach: |_, around| around.body_radius + around.tables,
    counterpart: Some(Counterpart {
        kind: "proximity",
        scale: Scale::Samples,
        nearness: 1.0,
    }),
    ..Entry::new(["sampled", "a column of the robot's tables of samples"], |_, each| {
        let (plane, sensor) = (each.column / SENSORS, each.column % SENSORS);
        let word = format!("sums{plane}.{}", ["x", "y", "z", "w"][sensor / 2]);
        let sum = if sensor % 2 == 0 {
            format!("{word} & 0xffffu")
        } else {
            format!("{word} >> 16u")
        };
        format!("activation({sum}, worlds[world].reading_scale)")
    })
};

/// The planes of eight sensors that a parametric robot's tables have, and those of them that its sensors read.
pub(crate) struct Planes {
    pub(crate) count: usize,
    pub(crate) read: Vec<usize>,
}

impl Planes {
    /// Those of tables with some sensors, and the column that each sensor of the robot reads.
    pub(crate) fn new(sensors: u32, columns: &[Option<u32>]) -> Self {
        let columns = columns.iter().flatten();
        let mut read: Vec<_> = columns.map(|column| *column as usize / SENSORS).collect();
        read.sort_unstable();
        read.dedup();
        Self {
            count: (sensors as usize).div_ceil(SENSORS),
            read,
        }
    }

    /// What comes before the loop over objects: the sums of readings.
    pub(crate) fn sums(&self) -> String {
        let sum = |plane: &usize| format!("    var sums{plane} = vec4<u32>(0u);\n");
        let sums: String = self.read.iter().map(sum).collect();
        format!("    var seen = Sighted();\n    let plane = worlds[world].rows * worlds[world].bearings;\n{sums}")
    }

    /// The code for each object: as in `sensor/sampled.wgsl`, one object of each layer is looked up. `sensor` is a sampled one.
    pub(crate) fn of_an_object(&self, sensor: usize) -> String {
        let sum = |plane: &usize| {
            let table = format!("seen.table + {plane}u * plane");
            format!("                sums{plane} += sampled(world, pose.z, seen.to, seen.contact, {table});\n")
        };
        let sums: String = self.read.iter().map(sum).collect();
        format!(
            "        let next = sighted(world, shape, pose, at, s{sensor}.range);
        if (next.in_reach) {{
            seen = next;
        }}
        if (shapes[shape].ends_layer != 0u) {{
            if (seen.in_reach) {{
{sums}            }}
            seen.in_reach = false;
        }}
"
        )
    }
}
