// The page of an episode.
import { shortened } from './chart.js';
import { Controllers } from './diagram.js';
import { element, legendEntry, made, say, set } from './dom.js';
import { bytes, facts } from './facts.js';
import { MESSAGE_PICTURE, drawMessages } from './messages.js';
import { Readings } from './readings.js';
import { PoseRecord, unpacked } from './record.js';
import { drawRobot } from './robots.js';
import { drawSensors } from './sensors.js';
import { Stage } from './stage.js';
import { robotRow, showRow, tableOf } from './table.js';
import { LONG_TRAIL, TRAIL, drawTrails } from './trails.js';

/** What robots do in an episode: a value for each line, for each robot. */
class Doings {
  /** @param {import('./facts.js').EpisodeFacts} data */
  constructor(data) {
    this.data = data;
    this.robots = data.names.length;
    /** Robots of each world. */
    this.each = this.robots / data.worlds.length;
    this.states = new Uint16Array(bytes(data.state));
    this.values = new Uint16Array(bytes(data.values));
    this.senders = new Uint16Array(bytes(data.senders));
    this.fitnesses = new Float32Array(bytes(data.fitness));
    this.earned = new Float32Array(bytes(data.earned));
    this.pucks = new Float32Array(bytes(data.pucks.places));
    /** Whether robots hear each other, whether each has a score, and whether each is alone in its world. */
    this.hears = this.senders.length > 0;
    this.scoresEach = this.earned.length > 0;
    this.apart = data.who !== 'robot';
  }

  /** @param {number} robot */
  worldOf(robot) {
    return Math.floor(robot / this.each);
  }

  /** @param {number} world @param {number} line */
  fitness(world, line) {
    return this.fitnesses[line * this.data.worlds.length + world];
  }

  /**
   * Where pucks are.
   * @param {number} world @param {number} line @returns {import('./facts.js').Place[]}
   */
  pucksIn(world, line) {
    const { count } = this.data.pucks;
    const first = count * (line * this.data.worlds.length + world);
    return Array.from({ length: count }, (_, puck) => [this.pucks[2 * (first + puck)], this.pucks[2 * (first + puck) + 1]]);
  }

  /** @param {number} robot @param {number} line */
  act(robot, line) {
    return this.data.acts[this.states[line * this.robots + robot]] || this.data.plain[robot];
  }

  /** @param {number} robot @param {number} line @param {number} index */
  reading(robot, line, index) {
    const { readings } = this.data;
    const { low, high, whole } = readings[index];
    const value = low + ((high - low) * this.values[(line * this.robots + robot) * readings.length + index]) / 65535;
    return whole ? Math.round(value) : value;
  }

  /** @param {number} robot @param {number} line */
  score(robot, line) {
    return this.apart ? this.fitness(robot, line) : this.earned[line * this.robots + robot];
  }

  /**
   * Robots whose messages this one has heard.
   * @param {number} robot @param {number} line
   */
  heardBy(robot, line) {
    const words = this.hears ? Math.ceil(this.each / 16) : 0;
    const at = (line * this.robots + robot) * words;
    const first = this.each * this.worldOf(robot);
    /** @type {number[]} */
    const heard = [];
    for (let other = 0; other < this.each && words > 0; other++) {
      if ((this.senders[at + (other >> 4)] >> (other & 15)) & 1) heard.push(first + other);
    }
    return heard;
  }
}

/** @type {import('./facts.js').EpisodeFacts} */
const data = facts();
const record = new PoseRecord({ ...data, ...unpacked(data) });
const doings = new Doings(data);
const { acts, plain, readings, sensors, who, worlds, arena: ground } = data;
const { names, robots, everyone } = record;
const { hears, apart, each } = doings;
const scoresEach = doings.scoresEach || apart;
const alone = robots === 1;
/** Whether one of several worlds is shown. */
const chosen = worlds.length > 1 && !apart;
/** The world that is shown, of which the last one is first. */
let shown = worlds.length - 1;
const Who = who[0].toUpperCase() + who.slice(1);
const Each = who === 'the' ? 'Robot' : Who;
/** Seconds for which a transition stays marked while the page plays. */
const MARKED = 0.7;
/** The reading that the chart shows; -1: fitness. */
let charted = -1;

/** @type {Stage} */
const stage = new Stage(record, data.body, {
  who,
  followed: robots - each,
  fit: () => arena.fitAround(data.view),
  show,
  told: (seconds) => {
    const { line } = record.locate(seconds);
    const value = valueAt(line);
    return `${record.clock(record.timeOf(line))}: ${value === null ? 'click a robot' : shortened(value)}`;
  },
});
const { arena, chart, player } = stage;
const bars = new Readings(readings);
const controllers = new Controllers(data);

/** @param {string} id */
const isOn = (id) => element(id, HTMLInputElement).checked;

function drawArena() {
  const { moment, followed } = player;
  arena.clear();
  arena.ground(ground);
  arena.scale(0.2 * (data.view.right - data.view.left));
  /** @type {(import('./record.js').Pose | null)[]} */
  const poses = [];
  record.everyone.forEach((robot) => { poses[robot] = record.pose(robot, moment); });
  if (isOn('trails')) {
    const width = Math.max(1.4, 5 * arena.view.scale);
    /** @param {number[]} robots @param {number} seconds @param {string} colour @param {number} width @param {number} strength */
    const draw = (robots, seconds, colour, width, strength) =>
      drawTrails(arena, record, moment, { robots, seconds, colour, width, strength });
    if (apart) everyone.forEach((robot) => draw([robot], LONG_TRAIL, plain[robot].colour, width, 0.6));
    else draw(record.everyone, TRAIL, arena.marks.ink, width, 0.4);
    if (!apart && followed >= 0) draw([followed], LONG_TRAIL, arena.marks.link, 2.4, 0.8);
  }
  if (hears && isOn('messages')) {
    for (const hearer of record.everyone) {
      const isFollowed = hearer === followed;
      const pairs = doings.heardBy(hearer, moment.line).map((sender) => /** @type {any} */ ([poses[hearer], poses[sender]]));
      drawMessages(arena, pairs, followed < 0 || isFollowed ? 0.9 : 0.45, isFollowed ? 3 : 1.6);
    }
  }
  record.everyone.forEach((robot) => {
    const pose = poses[robot];
    if (!pose) return;
    drawRobot(arena, pose, { body: data.body, name: names[robot], act: doings.act(robot, moment.line), followed: robot === followed });
  });
  // After the robots, so that those are seen that they carry.
  arena.pucks(doings.pucksIn(shown, moment.line), data.pucks.radius);
  const pose = poses[followed];
  if (pose && isOn('sensors')) {
    drawSensors(arena, pose, data.body, sensors, (index) =>
      Math.min(Math.max(doings.reading(followed, moment.line, index) / readings[index].to, 0), 1));
  }
}

const columns = [
  { text: Each },
  ...(acts.length > 0 ? [{ text: 'State' }] : []),
  ...(hears ? [{ text: 'Hears', className: 'hears', title: 'robots whose messages it hears' }] : []),
  ...(scoresEach ? [{ text: 'Score', className: 'score', title: 'what the task has given it so far' }] : []),
];
const table = element('robots', HTMLTableElement);
table.className = columns.length === 1 ? 'bare' : '';
const { body } = tableOf(table, columns);
const rows = everyone.map((robot) => {
  const own = robotRow(body, player, robot);
  return {
    ...own,
    does: acts.length > 0 ? made('td', own.row) : null,
    heard: hears ? made('td', own.row, { className: 'hears' }) : null,
    score: scoresEach ? made('td', own.row, { className: 'score' }) : null,
  };
});

/**
 * Shows another world at the same time, and the robot that was followed there.
 * @param {number} world
 */
function choose(world) {
  shown = world;
  record.everyone = everyone.filter((robot) => doings.worldOf(robot) === world);
  rows.forEach(({ row }, robot) => { row.hidden = doings.worldOf(robot) !== world; });
  buttons.forEach((button, own) => button.setAttribute('aria-pressed', String(own === world)));
  if (player.followed >= 0) player.followed = world * each + (player.followed % each);
  chooseChart();
}

const buttons = !chosen ? [] : worlds.map(({ name, colour }, world) => {
  const button = made('button', element('worlds', HTMLElement), { type: 'button', className: 'who' });
  made('span', button, { className: 'dot' }).style.background = colour;
  button.append(String(name));
  button.addEventListener('click', (event) => {
    choose(world);
    say(`Generation ${name}.`);
    player.ask();
    if (event.detail > 0) button.blur();
  });
  return button;
});

/** @param {number} line */
function showTable(line) {
  record.everyone.forEach((robot) => {
    const own = rows[robot];
    const act = doings.act(robot, line);
    showRow(own, robot === player.followed, act);
    if (own.does) set(own.does, 'textContent', act.name);
    if (own.heard) set(own.heard, 'textContent', String(doings.heardBy(robot, line).length));
    if (own.score) set(own.score, 'textContent', shortened(doings.score(robot, line)));
  });
}

/**
 * The states before and after a machine's last transition, if it was taken a moment ago.
 * @param {number} robot @param {number} line
 */
function takenBy(robot, line) {
  const since = player.time - MARKED * player.speed;
  for (let after = line; after > 0 && record.timeOf(after) >= since; after--) {
    const states = [after - 1, after].map((at) => doings.act(robot, at).name);
    if (states[0] !== states[1]) return states;
  }
  return [];
}

/** @param {number} line */
function showController(line) {
  const { followed } = player;
  const robot = followed < 0 ? shown * each : followed;
  const { name, colour } = doings.act(robot, line);
  controllers.show(robot, alone ? 'Controller' : `${Who} ${names[robot]} computes`, followed < 0 ? null : {
    reading: (index) => doings.reading(robot, line, index),
    act: name,
    taken: takenBy(robot, line),
    colour,
  });
}

/** The world that the words and the chart's thick curve are about. */
const worldNow = () => (apart ? Math.max(player.followed, 0) : shown);

/**
 * What the chart shows of a line; null without a robot that is followed.
 * @param {number} line
 */
function valueAt(line) {
  const { followed } = player;
  if (charted < 0) return doings.fitness(worldNow(), line);
  return followed < 0 ? null : doings.reading(followed, line, charted);
}

function chooseChart() {
  const { fitnesses } = doings;
  const { name, low, high } = charted < 0
    ? { name: 'Fitness', low: fitnesses.reduce((a, b) => Math.min(a, b), 0), high: fitnesses.reduce((a, b) => Math.max(a, b), 0) }
    : readings[charted];
  chart.span(record.last, Math.min(low, 0), Math.max(high, 0));
  chart.canvas.setAttribute('aria-label', `${name} over time, ${[Math.min(low, 0), Math.max(high, 0)].map(shortened).join(' to ')}`);
}

function drawChart() {
  const { followed, moment } = player;
  const { faint, link } = stage.theme.colours;
  const several = worlds.length > 1;
  chart.ground();
  if (several && charted < 0) {
    worlds.forEach(({ colour }, world) => chart.curve(record, record.lines - 1, (line) => doings.fitness(world, line), colour, 1.5));
  } else {
    chart.curve(record, record.lines - 1, valueAt, faint, 1.5);
  }
  chart.curve(record, moment.line, valueAt, several && (followed >= 0 || !apart) ? worlds[worldNow()].colour : link, 2.4);
  chart.cursor(player.time);
}

/** @param {number} line */
function showWords(line) {
  const { followed } = player;
  const world = worldNow();
  const whose = worlds.length > 1 ? `${apart ? Who : 'Generation'} ${worlds[world].name}: fitness` : 'Fitness';
  set(element('light', HTMLElement), 'textContent', `${whose} if the episode ended now: ${shortened(doings.fitness(world, line))}`);
  let text = alone ? 'Click the robot to see its sensors.' : 'Click a robot, or its button in the table, to follow it.';
  if (followed >= 0) {
    const others = doings.heardBy(followed, line).map((other) => names[other]).join(', ');
    const parts = [apart ? '' : doings.act(followed, line).name, hears ? `hears ${others ? `robot ${others}` : 'nobody'}` : ''];
    const told = parts.filter((part) => part).join('; ');
    text = `${Who} ${names[followed]}${told ? ': ' : ''}${told}`;
  }
  set(element('robot', HTMLElement), 'textContent', text);
}

function show() {
  const { line } = player.moment;
  if (chosen && player.followed >= 0 && doings.worldOf(player.followed) !== shown) choose(doings.worldOf(player.followed));
  const { followed } = player;
  drawArena();
  showController(line);
  const title = alone ? 'Readings' : `${Who} ${names[followed]} reads`;
  bars.show(followed < 0 ? 'Readings: click a robot' : title, followed < 0 ? null : (index) => doings.reading(followed, line, index));
  showTable(line);
  drawChart();
  showWords(line);
  player.showClock();
}

element('each', HTMLElement).hidden = alone;
element('robots-title', HTMLElement).textContent = `${Each}s`;
element('note', HTMLElement).textContent = scoresEach ? '' : 'The mission scores the swarm as a whole, and no robot by itself.';
/** @type {[string, boolean][]} */
const switches = [['messages', hears], ['sensors', sensors.length > 0], ['trails', true]];
for (const [id, useful] of switches) {
  const label = element(id, HTMLInputElement).parentElement;
  if (label) label.hidden = !useful;
  element(id, HTMLInputElement).addEventListener('change', () => player.ask());
}
element('trails', HTMLInputElement).checked = alone || apart;
const named = plain.filter(({ name }) => (apart || acts.length === 0) && name);
for (const [name, colour] of new Map([...acts, ...named].map(({ name, colour }) => [name, colour]))) {
  legendEntry(`<circle r="7.5" fill="${colour}" stroke="var(--rim)"/><path d="M7 0L3.2 3.4V-3.4Z" fill="var(--rim)"/>`, name);
}
if (hears) legendEntry(MESSAGE_PICTURE, 'hears now');
if (data.pucks.count > 0) legendEntry('<circle r="6" fill="var(--food)" stroke="var(--food-edge)"/>', 'puck');
if (ground.lamps.length > 0) legendEntry('<circle r="5" fill="var(--lamp)" stroke="var(--lamp-edge)"/>', 'lamp');
const choice = element('charted', HTMLSelectElement);
['fitness', ...readings.map(({ name }) => name)].forEach((name) => made('option', choice, { textContent: name }));
choice.addEventListener('change', () => {
  charted = choice.selectedIndex - 1;
  chooseChart();
  player.ask();
});
chart.view.left = 56;
if (chosen) choose(shown);
else chooseChart();

// For tests. `drawn` draws a time, and tells where robots were drawn, mm and turns, taken back from the canvas, and the colour of
// their side; `shown` tells where a robot is on the canvas now.
Object.assign(window, {
  oneiro: {
    /** @param {number} robot */
    shown(robot) {
      const pose = record.pose(robot, player.moment);
      return pose && arena.place(pose.x, pose.y);
    },
    /** @param {number} when */
    drawn: (when) => stage.stop(when),
  },
});
stage.begin();
