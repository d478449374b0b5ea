// A robot's sensors: where they are and look, and how much each reads.
import { faded } from './colours.js';

/**
 * @param {import('./arena.js').Arena} arena
 * @param {import('./record.js').Pose} pose
 * @param {number} body its radius in mm
 * @param {import('./facts.js').Sensor[]} sensors
 * @param {(reading: number) => number} strength of a reading, from 0 to 1
 */
export function drawSensors(arena, { x, y, heading }, body, sensors, strength) {
  const { pen, view } = arena;
  pen.save();
  pen.translate(...arena.place(x, y));
  pen.rotate(-2 * Math.PI * heading);
  for (const { reading, bearing, heading: looks, offset, range, width } of sensors) {
    const share = strength(reading);
    const colour = faded(arena.marks.sensor, 0.25 + 0.75 * share);
    if (width !== undefined) {
      const half = Math.PI * width;
      pen.beginPath();
      pen.arc(0, 0, body * view.scale + 2, -2 * Math.PI * looks - half, -2 * Math.PI * looks + half);
      arena.stroke(colour, 2 + 3 * share);
      continue;
    }
    /** @param {number} turns */
    const turned = (turns) => [Math.cos(2 * Math.PI * turns), -Math.sin(2 * Math.PI * turns)];
    const [[right, down], [ahead, aside]] = [turned(bearing), turned(looks)];
    const [left, top] = [right * offset * view.scale, down * offset * view.scale];
    if (range) {
      pen.beginPath();
      pen.moveTo(left, top);
      pen.lineTo(left + ahead * range * view.scale, top + aside * range * view.scale);
      arena.stroke(colour, 1 + 2.5 * share);
    }
    arena.disc(left, top, 2 + 2 * share);
    arena.fill(colour);
  }
  pen.restore();
}
