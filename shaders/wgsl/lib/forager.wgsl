// What a forager and its arena are: numbers that its sensors, its wheels, its behaviours and its task read. The arena
// is a circle around the origin. Lengths in mm, angles in turns, times in cycles.

// Cells of a forager's world, from `worlds[..].numbers` on.
const NEST: u32 = 0u; // centre x and y, squared radius, squared radius of a food item
const LAMP: u32 = 1u; // x, y, decay per mm, and 1 if it shines; of a swarm x as if it were opposite
const SENSING: u32 = 2u; // ambient light, its noise, range of the proximity sensors, entries per mm of their curve
const ROBOT: u32 = 3u; // radius of the body, half a turn's wheel path per turn, farthest a wheel goes, noise of wheels
const DRIVING: u32 = 4u; // cruise, turn on the spot, turn per turn off the light, fastest such turn
const TIMES: u32 = 5u; // straight on after an escape, mean between random turns, what counts as near, time limit in s
const ARENA: u32 = 6u; // radius, seconds of a cycle, food items, robots
const AXES: u32 = 7u; // cosines and sines of the bearings of the four sensors at the front, then of the others
const CURVE: u32 = 11u; // two entries a cell: reading and its relative noise, by distance
