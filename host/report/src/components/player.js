// The dock: plays a record, and says whom the reader follows. A fragment such as #t=754&robot=3 opens the page at that second, paused,
// following that robot.
import { element, isCalm, made, say, set, setAttribute } from './dom.js';

const SPEEDS = [1, 2, 5, 10, 20, 50, 100];
/** A record takes at most about so many seconds to play, unless a speed is asked for. */
const PLAYED = 25;

/** Time, speed and the followed robot of a page. */
export class Player {
  /**
   * @param {import('./record.js').PoseRecord} record
   * @param {object} settings
   * @param {() => void} settings.show draws everything as it is now
   * @param {string} [settings.who] what the names of robots number
   * @param {number} [settings.followed]
   * @param {number} [settings.speed]
   */
  constructor(record, { show, who = 'robot', followed = -1, speed }) {
    this.record = record;
    this.show = show;
    this.who = who;
    this.followed = followed;
    this.time = record.first;
    this.playing = false;
    this.speed = speed || SPEEDS.find((times) => record.last / times <= 1.2 * PLAYED) || SPEEDS[SPEEDS.length - 1];
    /** Whether a frame will come, and when the one before came. */
    this.due = false;
    this.before = 0;
    this.slider = element('when', HTMLInputElement);
    this.select = element('speed', HTMLSelectElement);
    this.button = element('play', HTMLButtonElement);
    SPEEDS.forEach((times) => made('option', this.select, { textContent: `${times}\u00d7` }));
    this.setSpeed(SPEEDS.indexOf(this.speed));
    this.spread();
    this.listen();
  }

  /** The line that is shown. */
  get moment() {
    return this.record.locate(this.time);
  }

  /**
   * Goes on with another record.
   * @param {import('./record.js').PoseRecord} record @param {number} time
   */
  replace(record, time) {
    this.record = record;
    this.spread();
    this.seek(time);
  }

  /**
   * Opens the page where its fragment says. Else it may play, unless the reader asks for little motion.
   * @param {boolean} plays
   */
  begin(plays) {
    const wanted = new URLSearchParams(location.hash.slice(1));
    if (wanted.has('robot')) this.followed = this.record.names.lastIndexOf(Number(wanted.get('robot')));
    if (wanted.has('t')) this.seek(Number(wanted.get('t')) || 0);
    else if (plays && !isCalm()) this.play(true);
    this.show();
  }

  /** Fits what depends on how long the record is. */
  spread() {
    const { first, last, lines } = this.record;
    Object.assign(this.slider, { min: first, max: last, disabled: lines < 2 });
    for (const id of ['play', 'back', 'forth']) element(id, HTMLButtonElement).disabled = lines < 2;
  }

  /** Asks for a frame. */
  ask() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  /** @param {number} now in ms */
  frame(now) {
    this.due = false;
    if (this.playing) {
      // After a pause of the page itself it goes on, and does not jump.
      this.time += (Math.min(Math.max(now - this.before, 0), 100) / 1000) * this.speed;
      if (this.time >= this.record.last) {
        this.time = this.record.last;
        this.play(false);
      }
    }
    this.before = now;
    this.show();
    if (this.playing) this.ask();
  }

  /** @param {boolean} on */
  play(on) {
    if (on && this.record.lines < 2) return;
    if (on && this.time >= this.record.last) this.time = this.record.first;
    this.playing = on;
    this.before = performance.now();
    set(this.button, 'textContent', on ? 'Pause' : 'Play');
    this.ask();
  }

  /** @param {number} to in seconds */
  seek(to) {
    this.time = Math.min(Math.max(to, this.record.first), this.record.last);
    this.ask();
  }

  /** @param {number} count lines */
  stepBy(count) {
    this.play(false);
    const { record } = this;
    const { line, share } = this.moment;
    // From between two lines, back means to the one before.
    const from = share > 0 && count < 0 ? line + 1 : line;
    if (record.lines > 0) this.seek(record.timeOf(Math.min(Math.max(from + count, 0), record.lines - 1)));
  }

  /** @param {number} robot -1: none */
  follow(robot) {
    this.followed = robot;
    say(robot < 0 ? `Following no ${this.who}.` : `Following ${this.who} ${this.record.names[robot]}.`);
    this.ask();
  }

  /**
   * Follows a robot, or lets go of it.
   * @param {number} robot
   */
  toggle(robot) {
    this.follow(robot === this.followed ? -1 : robot);
  }

  /** @param {number} index of the list of speeds */
  setSpeed(index) {
    const at = Math.min(Math.max(index, 0), SPEEDS.length - 1);
    this.speed = SPEEDS[at];
    this.select.selectedIndex = at;
  }

  showClock() {
    const { record, slider, time } = this;
    if (Number(slider.value) !== time) slider.value = String(time);
    const [now, end] = [record.clock(time), record.clock(record.last)];
    if (slider.getAttribute('aria-valuetext') === `${now} of ${end}`) return;
    setAttribute(slider, 'aria-valuetext', `${now} of ${end}`);
    const box = element('clock', HTMLElement);
    box.replaceChildren();
    made('b', box, { textContent: now });
    made('span', box, { textContent: ` of ${end}` });
  }

  listen() {
    this.button.addEventListener('click', () => this.play(!this.playing));
    element('back', HTMLButtonElement).addEventListener('click', () => this.stepBy(-1));
    element('forth', HTMLButtonElement).addEventListener('click', () => this.stepBy(1));
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    this.select.addEventListener('change', () => this.setSpeed(this.select.selectedIndex));
    document.addEventListener('keydown', (event) => this.press(event));
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    const { key, target } = event;
    // Buttons and lists keep the keys that they need.
    if (key === ' ' && (target instanceof HTMLButtonElement || (target instanceof HTMLInputElement && target.type === 'checkbox'))) return;
    if (target instanceof HTMLSelectElement && key !== 'Escape') return;
    const many = event.shiftKey ? 10 : 1;
    /** @type {Record<string, () => void>} */
    const acts = {
      ' ': () => this.play(!this.playing),
      ArrowLeft: () => this.stepBy(-many),
      ArrowRight: () => this.stepBy(many),
      Home: () => this.seek(this.record.first),
      End: () => this.seek(this.record.last),
      '+': () => this.setSpeed(SPEEDS.indexOf(this.speed) + 1),
      '-': () => this.setSpeed(SPEEDS.indexOf(this.speed) - 1),
      Escape: () => this.follow(-1),
    };
    if (!(key in acts)) return;
    event.preventDefault();
    acts[key]();
  }
}
