// What a surrogate robot and its surroundings are: numbers that its sensors and its wheels read.

// Cells of a surrogate robot, in `tables`: three for each sensor (where it is and looks, its rays' weights, its
// curve), four waves of the illumination, and three of strengths.
const SENSOR_CELLS: u32 = 3u;
const WAVES: u32 = 24u;
const WAVE_COUNT: u32 = 4u;
const SENSING: u32 = 28u;
const TIMING: u32 = 29u;
const WHEELS: u32 = 30u;
