// Robots in the arena, and which of them is under the pointer.
import { FONT, inkOn } from './colours.js';

/**
 * Draws a robot in a state's colours.
 * @param {import('./arena.js').Arena} arena
 * @param {import('./record.js').Pose} pose
 * @param {object} robot
 * @param {number} robot.body radius in mm
 * @param {number | string} robot.name a number is drawn on it
 * @param {import('./facts.js').Act} robot.act
 * @param {boolean} robot.followed
 * @param {(radius: number) => void} [robot.under] draws what it carries
 */
export function drawRobot(arena, { x, y, heading }, { body, name, act: { colour, front }, followed, under }) {
  const { pen, put, marks } = arena;
  const radius = body * arena.view.scale;
  pen.save();
  pen.translate(...arena.place(x, y));
  pen.rotate(-2 * Math.PI * heading);
  put.robots.push({ name, ...arena.standing() });
  // On its side, where nothing else is painted on it.
  const { x: left, y: top } = pen.getTransform().transformPoint({ x: 0, y: 0.75 * radius });
  put.sides.push([left, top]);
  if (under) under(radius);
  arena.disc(0, 0, radius);
  arena.fill(colour);
  arena.stroke(front || marks.rim, 1.2);
  // The front.
  pen.beginPath();
  pen.moveTo(0.98 * radius, 0);
  pen.lineTo(0.5 * radius, 0.5 * radius);
  pen.lineTo(0.5 * radius, -0.5 * radius);
  pen.closePath();
  arena.fill(front || marks.rim);
  pen.restore();
  const [middle, height] = arena.place(x, y);
  if (followed) {
    // With a rim, to be seen on any floor.
    for (const [style, width] of /** @type {[string, number][]} */ ([[marks.page, 5], [marks.link, 2.5]])) {
      arena.disc(middle, height, radius + 5);
      arena.stroke(style, width);
    }
  }
  if (radius < 9.5 || typeof name === 'string') return;
  // Behind the front, where there is room.
  const turn = 2 * Math.PI * heading;
  const size = radius * (name > 99 ? 0.72 : 0.84);
  pen.font = `700 ${size.toFixed(1)}px ${FONT}`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillStyle = inkOn(colour);
  const shift = 0.24 * radius;
  pen.fillText(String(name), middle - shift * Math.cos(turn), height + shift * Math.sin(turn) + 0.06 * size);
}

/**
 * Lets the reader follow a robot by a click on it.
 * @param {import('./arena.js').Arena} arena
 * @param {import('./player.js').Player} player
 * @param {number} body
 */
export function listenToRobots(arena, player, body) {
  const { canvas } = arena;
  /** @param {MouseEvent} event */
  const under = (event) => {
    const { record, moment } = player;
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let best = { robot: -1, distance: Math.max(1.3 * body * arena.view.scale, 14) };
    for (const robot of record.everyone) {
      const pose = record.pose(robot, moment);
      if (!pose) continue;
      const [left, top] = arena.place(pose.x, pose.y);
      const distance = Math.hypot(left - x, top - y);
      if (distance < best.distance) best = { robot, distance };
    }
    return best.robot;
  };
  canvas.addEventListener('click', (event) => player.toggle(under(event)));
  canvas.addEventListener('mousemove', (event) => {
    canvas.style.cursor = under(event) < 0 ? 'default' : 'pointer';
  });
}
