// Poses of robots over time.
import { bytes } from './facts.js';

/** @typedef {{ line: number, share: number }} Moment a line, and the share of the way to the next */
/** @typedef {{ x: number, y: number, heading: number }} Pose mm, and turns counter-clockwise */
/**
 * @typedef {object} Poses
 * @property {(number | string)[]} names
 * @property {ArrayLike<number>} times each line's cycle
 * @property {number} unit
 * @property {Int16Array} xs
 * @property {Int16Array} ys
 * @property {Uint16Array} headings
 */

/** Position of a robot whose pose is unknown. */
const NOWHERE = -32768;

/**
 * Unpacks a page's poses.
 * @param {import('./facts.js').PoseFacts} facts
 */
export const unpacked = ({ x, y, heading, unit }) => ({
  unit, xs: new Int16Array(bytes(x)), ys: new Int16Array(bytes(y)), headings: new Uint16Array(bytes(heading)),
});

/** A record of poses, line after line. Times are in seconds. */
export class PoseRecord {
  /** @param {Poses} poses */
  constructor(poses) {
    this.poses = poses;
    this.names = poses.names;
    this.robots = poses.names.length;
    /** Those that are shown. */
    this.everyone = poses.names.map((_, robot) => robot);
    this.lines = poses.times.length;
    this.first = this.lines > 0 ? this.timeOf(0) : 0;
    this.last = this.lines > 0 ? this.timeOf(this.lines - 1) : 0;
    this.every = this.lines > 1 ? this.timeOf(1) - this.first : 1;
  }

  /** @param {number} line */
  timeOf(line) {
    return this.poses.times[line] / 10;
  }

  /**
   * The last line up to a time, -1 before the first.
   * @param {number} when
   */
  lineAt(when) {
    let [from, to] = [0, this.lines];
    while (from < to) {
      const middle = (from + to) >> 1;
      if (this.poses.times[middle] <= when * 10 + 1e-6) from = middle + 1;
      else to = middle;
    }
    return from - 1;
  }

  /**
   * The line at or before a time, and the share of the way to the next.
   * @param {number} when @returns {Moment}
   */
  locate(when) {
    const line = Math.max(this.lineAt(when), 0);
    if (line + 1 >= this.lines) return { line, share: 0 };
    const share = (when - this.timeOf(line)) / (this.timeOf(line + 1) - this.timeOf(line));
    return { line, share: share < 1e-9 ? 0 : share };
  }

  /**
   * Where a robot is; null if that is unknown. Between lines it goes straight and turns the shorter way.
   * @param {number} robot
   * @param {Moment} moment
   * @returns {Pose | null}
   */
  pose(robot, { line, share }) {
    const { xs, ys, headings, unit } = this.poses;
    const at = line * this.robots + robot;
    if (at >= xs.length || xs[at] === NOWHERE) return null;
    let [x, y, heading] = [xs[at], ys[at], headings[at]];
    const next = at + this.robots;
    if (share > 0 && xs[next] !== NOWHERE) {
      x += share * (xs[next] - x);
      y += share * (ys[next] - y);
      heading += share * (((headings[next] - heading + 98304) & 65535) - 32768);
    }
    return { x: x * unit, y: y * unit, heading: heading / 65536 };
  }

  /**
   * Minutes and seconds, with tenths where lines are closer than a second.
   * @param {number} seconds
   */
  clock(seconds) {
    const tenths = this.every % 1 === 0 ? 0 : 1;
    const whole = Math.floor(seconds * 10 ** tenths + 1e-6) / 10 ** tenths;
    const rest = (whole % 60).toFixed(tenths);
    return `${Math.floor(whole / 60)}:${rest.padStart(tenths === 0 ? 2 : 4, '0')}`;
  }
}
