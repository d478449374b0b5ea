// Where robots came from.

/** Seconds of a trail, and of that of the robot that is followed. */
export const TRAIL = 20;
export const LONG_TRAIL = 60;

/**
 * Draws ways of the last seconds: all pieces of one age at once, since there may be many robots.
 * @param {import('./arena.js').Arena} arena
 * @param {import('./record.js').PoseRecord} record
 * @param {import('./record.js').Moment} moment
 * @param {object} trail
 * @param {number[]} trail.robots
 * @param {number} trail.seconds
 * @param {string} trail.colour
 * @param {number} trail.width
 * @param {number} trail.strength from 0 to 1
 */
export function drawTrails(arena, record, moment, { robots, seconds, colour, width, strength }) {
  const { pen } = arena;
  const step = Math.max(1, Math.round(0.5 / record.every));
  const pieces = Math.ceil(seconds / (step * record.every));
  pen.lineCap = 'butt';
  let newer = robots.map((robot) => record.pose(robot, moment));
  for (let piece = 0; piece < pieces; piece++) {
    const line = moment.line - piece * step - (moment.share > 0 ? 0 : step);
    if (line < 0) break;
    const older = robots.map((robot) => record.pose(robot, { line, share: 0 }));
    pen.globalAlpha = strength * (1 - piece / pieces);
    pen.beginPath();
    older.forEach((from, i) => {
      const to = newer[i];
      if (!from || !to) return;
      pen.moveTo(...arena.place(to.x, to.y));
      pen.lineTo(...arena.place(from.x, from.y));
    });
    arena.stroke(colour, width);
    newer = older;
  }
  pen.globalAlpha = 1;
}
