// The page of foragers, or of a fleet. While a fleet lives, a script beside the page brings newer data every second.
import { rounded } from './chart.js';
import { element, isCalm, legendEntry, made, say, set, setAttribute } from './dom.js';
import { bytes, facts } from './facts.js';
import { MESSAGE_PICTURE, drawMessages } from './messages.js';
import { PoseRecord, unpacked } from './record.js';
import { drawRobot } from './robots.js';
import { faded } from './colours.js';
import { Stage } from './stage.js';
import { robotRow, showRow, tableOf } from './table.js';
import { LONG_TRAIL, TRAIL, drawTrails } from './trails.js';

/** @typedef {import('./facts.js').ForagersFacts} Facts */

const LIGHTS = { over: 'over the nest', none: 'off', opposite: 'opposite the nest' };
/** An age or a fitness that is unknown. */
const UNKNOWN = 65535;
/** Seconds without anything new after which a page that shows a fleet says so. */
const SILENCE = 3;
/** Seconds before the light moves in which its next place is shown. */
const NOTICE = 60;

/** What foragers do, line after line. */
class Foraging {
  /** @param {Facts} data */
  constructor(data) {
    this.data = data;
    const record = new PoseRecord({ ...data, ...unpacked(data) });
    const { lines, robots } = record;
    this.record = record;
    this.states = new Uint16Array(bytes(data.state));
    this.earned = new Uint16Array(bytes(data.earned));
    this.ages = new Uint16Array(bytes(data.age || ''));
    this.problem = new Uint16Array(bytes(data.problem || ''));
    this.foodXs = new Int16Array(bytes(data.food_x));
    this.foodYs = new Int16Array(bytes(data.food_y));
    this.items = lines > 0 ? this.foodXs.length / lines : 0;
    /** Pairs of who heard whom, and where those of each line begin. */
    this.heard = new Uint16Array(bytes(data.heard));
    this.heardFrom = new Uint32Array(lines + 1);
    /** Food that was brought up to each line, by each robot and in all. */
    this.brought = new Uint16Array(lines * robots);
    this.broughtByAll = new Uint32Array(lines);
    for (let line = 0, at = 0; line < lines; line++) {
      this.heardFrom[line] = at + 1;
      at += 1 + this.heard[at];
      this.heardFrom[line + 1] = at + 1;
      let all = line > 0 ? this.broughtByAll[line - 1] : 0;
      for (let robot = 0; robot < robots; robot++) {
        const now = this.states[line * robots + robot] >> 5;
        this.brought[line * robots + robot] = now + (line > 0 ? this.brought[(line - 1) * robots + robot] : 0);
        all += now;
      }
      this.broughtByAll[line] = all;
    }
  }

  /** @param {number} robot @param {number} line */
  act(robot, line) {
    return this.data.acts[this.states[line * this.record.robots + robot] & 15];
  }

  /** @param {number} robot @param {number} line */
  carries(robot, line) {
    return ((this.states[line * this.record.robots + robot] >> 4) & 1) === 1;
  }

  /**
   * Food that a robot has just brought.
   * @param {number} robot @param {number} line
   */
  brings(robot, line) {
    return this.states[line * this.record.robots + robot] >> 5;
  }

  /**
   * Who heard whom: pairs of a hearer and a sender.
   * @param {number} line @returns {[number, number][]}
   */
  pairs(line) {
    const pairs = this.heard.subarray(this.heardFrom[line], this.heardFrom[line + 1] - 1);
    return Array.from(pairs, (pair) => [pair >> 8, pair & 255]);
  }

  /**
   * Where the light is, and where it will be next within the record.
   * @param {number} when
   */
  lightAt(when) {
    let now = this.data.lights[0][1];
    /** @type {{ at: number, where: import('./facts.js').Light } | null} */
    let next = null;
    for (const [cycle, where] of this.data.lights.slice(1)) {
      // Half a cycle of room for rounding.
      if (when * 10 + 0.5 >= cycle) now = where;
      else next = next || { at: cycle / 10, where };
    }
    return { now, next: next && next.at <= this.record.last ? next : null };
  }

  /**
   * A robot's genes; null before it has some.
   * @param {number} robot @param {number} when
   */
  genesAt(robot, when) {
    let found = null;
    for (const change of this.data.genes[robot] || []) {
      if (change[0] <= when * 10 + 0.5) found = change;
      else break;
    }
    return found;
  }
}

/** @type {Facts} */
const fixed = facts();
let foraging = new Foraging(fixed);
const { names } = fixed;
const everyone = names.map((_, robot) => robot);
/** @type {Stage} */
const stage = new Stage(foraging.record, fixed.body, { fit, show, speed: 10, told: (seconds) => barText(barOf(seconds)) });
const { arena, chart, player } = stage;

// ---- The arena.

const lampGap = Math.min(fixed.lamp, 0.4 * fixed.arena);

function fit() {
  const lit = foraging.data.lights.some(([, where]) => where !== 'none');
  const half = { x: fixed.arena * 1.04 + (lit ? lampGap + 0.14 * fixed.arena : 0), y: fixed.arena * 1.04 };
  arena.fitTo({ left: -half.x, right: half.x, bottom: -half.y, top: half.y });
}

/** @param {import('./facts.js').Light} where */
const lampPlace = (where) => arena.place((where === 'over' ? -1 : 1) * (fixed.arena + lampGap), 0);

/** @param {import('./facts.js').Light} light */
function drawGround(light) {
  const { pen, colours, view } = arena;
  const [x, y] = arena.place(0, 0);
  const radius = fixed.arena * view.scale;
  pen.save();
  arena.disc(x, y, radius);
  arena.fill(colours.floor);
  pen.clip();
  if (light !== 'none') {
    const reach = (2 * fixed.arena + lampGap) * view.scale;
    pen.fillStyle = arena.glow(lampPlace(light), reach, (share) => {
      const metres = (share * reach) / view.scale / 1000;
      return 0.62 * Math.exp(-fixed.decay * metres) * (1 - share);
    });
    pen.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
  }
  arena.disc(...arena.place(-fixed.arena, 0), fixed.nest * view.scale);
  arena.fill(faded(colours.nest, 0.25));
  pen.setLineDash([6, 4]);
  arena.stroke(colours.nest, 1.5);
  pen.setLineDash([]);
  pen.restore();
  arena.disc(x, y, radius + 2);
  arena.stroke(colours.ink, 4);
  const inside = fixed.arena - Math.min(0.5 * fixed.nest, fixed.arena);
  arena.words('nest', arena.place(-inside, 0), arena.small, colours['nest-text'], 600);
}

/** @param {ReturnType<Foraging['lightAt']>} light @param {number} when */
function drawLamp({ now, next }, when) {
  const { pen, colours, small } = arena;
  const size = Math.max(5, 26 * arena.view.scale);
  const soon = next && next.at - when <= NOTICE ? next : null;
  const seconds = soon ? Math.ceil(soon.at - when) : 0;
  /** @param {string} text @param {[number, number]} place */
  const label = (text, [x, y]) => arena.words(text, [x, y + 1.8 * size + small], small, colours['lamp-text'], 600);
  if (now !== 'none') {
    arena.sun(...lampPlace(now), size);
    label(soon && soon.where === 'none' ? `off in ${seconds} s` : 'light', lampPlace(now));
  }
  if (soon && soon.where !== 'none') {
    arena.disc(...lampPlace(soon.where), 1.25 * size);
    pen.setLineDash([4, 3]);
    arena.stroke(colours['lamp-edge'], 1.6);
    pen.setLineDash([]);
    label(`in ${seconds} s`, lampPlace(soon.where));
  }
}

/**
 * Places of the food as it was drawn, in mm, for tests.
 * @type {[number, number][]}
 */
let putFood = [];

/** @param {number} line @param {number} when */
function drawFood(line, when) {
  const { pen, colours, view } = arena;
  const { items, foodXs, foodYs, record } = foraging;
  for (let at = line * items; at < (line + 1) * items; at++) {
    // Food that was just put there grows in a moment.
    const before = at - items;
    const isNew = before >= 0 && (foodXs[before] !== foodXs[at] || foodYs[before] !== foodYs[at]);
    const grown = isNew && player.playing && !isCalm() ? Math.min(1, 0.3 + (when - record.timeOf(line)) / record.every) : 1;
    pen.save();
    pen.translate(...arena.place(foodXs[at] * fixed.unit, foodYs[at] * fixed.unit));
    const { x, y } = arena.standing();
    putFood.push([x, y]);
    arena.disc(0, 0, fixed.food * view.scale * grown);
    arena.fill(faded(colours.food, 0.3));
    arena.stroke(faded(colours['food-edge'], 0.55), 1);
    arena.disc(0, 0, Math.max(3, 13 * view.scale));
    arena.fill(colours.food);
    arena.stroke(colours['food-edge'], 1.2);
    pen.restore();
  }
}

/**
 * Draws what flashes: long enough to be seen at any speed.
 * @param {import('./record.js').Moment} moment
 * @param {number} when
 * @param {(line: number, strength: number) => void} draw
 */
function eachFlash(moment, when, draw) {
  const lasts = player.playing ? Math.max(1.2, 0.3 * player.speed) : 1;
  for (let line = moment.line; line >= 0; line--) {
    const age = (when - foraging.record.timeOf(line)) / lasts;
    if (age >= 1) break;
    draw(line, isCalm() ? 1 : 1 - Math.max(age, 0));
  }
}

/** @param {number} robot @param {import('./record.js').Pose} pose @param {number} line */
function drawForager(robot, pose, line) {
  const { colours } = arena;
  drawRobot(arena, pose, {
    body: fixed.body,
    name: names[robot],
    act: foraging.act(robot, line),
    followed: robot === player.followed,
    under(radius) {
      if (!foraging.carries(robot, line)) return;
      arena.disc(-0.95 * radius, 0, Math.max(3, 0.46 * radius));
      arena.fill(colours.food);
      arena.stroke(colours['food-edge'], 1.4);
    },
  });
}

/** @param {number} when */
function drawArena(when) {
  const { pen, colours, view } = arena;
  const { record } = foraging;
  const { followed } = player;
  arena.clear();
  putFood = [];
  const light = foraging.lightAt(when);
  drawGround(light.now);
  drawLamp(light, when);
  arena.scale(0.35 * fixed.arena);
  if (record.lines === 0) return;
  const moment = record.locate(when);
  drawFood(moment.line, when);
  const width = Math.max(1.4, 5 * view.scale);
  drawTrails(arena, record, moment, { robots: everyone, seconds: TRAIL, colour: colours.ink, width, strength: 0.3 });
  if (followed >= 0) {
    drawTrails(arena, record, moment, { robots: [followed], seconds: LONG_TRAIL, colour: colours.link, width: 2.4, strength: 0.8 });
  }
  const poses = everyone.map((robot) => record.pose(robot, moment));
  const pose = poses[followed];
  if (pose) {
    arena.disc(...arena.place(pose.x, pose.y), fixed.range * view.scale);
    pen.setLineDash([3, 5]);
    arena.stroke(faded(colours.message, 0.6), 1.2);
    pen.setLineDash([]);
  }
  eachFlash(moment, when, (line, strength) => {
    for (const ours of followed < 0 ? [false] : [false, true]) {
      const pairs = foraging.pairs(line).filter((pair) => followed < 0 || pair.includes(followed) === ours);
      const ends = pairs.map(([hearer, other]) => /** @type {any} */ ([poses[hearer], poses[other]]));
      drawMessages(arena, ends, strength * (followed < 0 || ours ? 0.75 : 0.2), ours ? 3 : 2);
    }
  });
  poses.forEach((at, robot) => at && drawForager(robot, at, moment.line));
  eachFlash(moment, when, (line, strength) => {
    poses.forEach((at, robot) => {
      const count = foraging.brings(robot, line);
      if (!at || count === 0) return;
      const [x, y] = arena.place(at.x, at.y);
      const radius = fixed.body * view.scale;
      pen.globalAlpha = strength;
      arena.disc(x, y, radius * (1.5 + (isCalm() ? 0 : 1 - strength)));
      arena.stroke(colours['food-edge'], 3);
      arena.words(`+${count}`, [x, y - 1.7 * radius - 8], Math.max(12, 0.9 * radius), colours['food-text'], 700);
      pen.globalAlpha = 1;
    });
  });
}

// ---- The robots' table.

const evolves = fixed.genes.length > 0;
/** Whether robots report themselves, and may fall silent. */
const reports = 'age' in fixed;
const THIRDS = [['flees the light', 'flee'], ['searches at random', 'rand.'], ['seeks the light', 'seek']];
const GENES = [
  { name: 'S0', short: 'light', about: 'what its simulator assumes of the light', kind: 'scenario',
    bands: [['opposite the nest', 'opp.'], ['none', 'none'], ['over the nest', 'over']] },
  { name: 'G0', short: 'with food', about: 'what it does with food', kind: 'acts', bands: THIRDS },
  { name: 'G1', short: 'without', about: 'what it does without food', kind: 'acts', bands: THIRDS },
];
const genes = evolves ? GENES : [];

/**
 * A cell that shows a gene as marks on its three bands.
 * @param {HTMLTableRowElement} row @param {string} kind @param {number} count
 */
function strip(row, kind, count) {
  const box = made('div', made('td', row, { className: 'gene' }), { className: `strip ${kind}` });
  box.setAttribute('role', 'img');
  return { box, marks: Array.from({ length: count }, () => made('s', box, { hidden: true })), told: '' };
}

/** @param {HTMLTableRowElement} row */
function foodCell(row) {
  const box = made('div', made('td', row, { className: 'food' }));
  return { count: made('b', box), bar: made('u', box) };
}

const table = element('robots', HTMLTableElement);
table.className = reports ? 'reports' : '';
const { body, cells: heads } = tableOf(table, [
  { text: 'Robot' },
  { text: 'Does', className: 'does' },
  ...(reports ? [{ text: 'Heard', title: 'how long ago it said anything' }] : []),
  ...genes.map(({ name, about }) => ({ text: `${name} `, className: 'gene', title: about })),
  { text: 'Food', className: 'food' },
]);
const bands = genes.map(({ short, bands: all }, i) => {
  const head = heads[i + (reports ? 3 : 2)];
  made('small', head, { textContent: short });
  const box = made('div', head, { className: 'names' });
  return all.map(([long, text]) => made('span', box, { textContent: text, title: long }));
});

function rowOfAll() {
  if (names.length < 2) return null;
  const row = made('tr', body, { className: 'all' });
  made('th', row, { textContent: 'All', scope: 'row' });
  made('td', row, { className: 'does' });
  if (reports) made('td', row);
  // Many marks are fainter, so that it shows where they are close.
  row.style.setProperty('--faintness', String(Math.min(0.5, Math.max(0.1, 5 / names.length))));
  return { strips: genes.map(({ kind }) => strip(row, kind, names.length)), food: foodCell(row) };
}

const all = rowOfAll();
const rows = everyone.map((robot) => {
  const own = robotRow(body, player, robot);
  const cell = made('td', own.row, { className: 'does' });
  const does = made('span', cell);
  const reported = reports ? { problems: made('small', cell), age: made('td', own.row, { className: 'age' }) } : null;
  return { ...own, does, reported, strips: genes.map(({ kind }) => strip(own.row, kind, 1)), food: foodCell(own.row) };
});

/** @param {ReturnType<typeof strip>} cell @param {string} text */
function tellStrip({ box }, text) {
  box.setAttribute('aria-label', text);
  box.title = text;
}

/** @param {number} robot @param {boolean} loaded @param {number} when */
function showGenes(robot, loaded, when) {
  const found = foraging.genesAt(robot, when);
  rows[robot].strips.forEach((own, i) => {
    const used = found !== null && (i === 0 || (i === 1) === loaded);
    const value = found === null ? 0 : /** @type {number} */ (found[i + 1]);
    const told = found === null ? 'none yet' : `${value}/${used}`;
    if (own.told === told) return;
    own.told = told;
    tellStrip(own, found === null ? 'none yet' : `${GENES[i].name} ${value.toFixed(2)}: ${GENES[i].bands[found[4][i]][0]}`);
    for (const mark of all ? [own.marks[0], all.strips[i].marks[robot]] : own.marks) {
      mark.hidden = found === null;
      mark.style.left = `${(100 * value).toFixed(2)}%`;
    }
    own.marks[0].className = used ? 'used' : '';
  });
}

/** @param {number} when */
function showTable(when) {
  const { record, data, brought, broughtByAll } = foraging;
  if (record.lines === 0) return;
  const { line } = record.locate(when);
  const light = foraging.lightAt(when).now;
  const most = Math.max(...brought.subarray((record.lines - 1) * record.robots));
  (bands[0] || []).forEach((span, i) => set(span, 'className', ['opposite', 'none', 'over'][i] === light ? 'true' : ''));
  rows.forEach((own, robot) => {
    const act = foraging.act(robot, line);
    const loaded = foraging.carries(robot, line);
    const at = line * record.robots + robot;
    showRow(own, robot === player.followed, act, loaded ? 'var(--food)' : '');
    set(own.does, 'textContent', act.short || '');
    set(own.food.count, 'textContent', String(brought[at]));
    setAttribute(own.food.bar, 'style', `background-size: ${most > 0 ? (100 * brought[at]) / most : 0}% 100%`);
    if (own.reported && data.problems) {
      const age = foraging.ages[at];
      set(own.reported.age, 'textContent', age === UNKNOWN ? 'never' : `${(age / 10).toFixed(1)} s ago`);
      const text = data.problems[foraging.problem[at]];
      set(own.reported.problems, 'textContent', text);
      set(own.reported.problems, 'title', text);
    }
    showGenes(robot, loaded, when);
  });
  if (!all) return;
  set(all.food.count, 'textContent', String(broughtByAll[line]));
  all.strips.forEach((own, i) => {
    const counts = [0, 0, 0];
    for (const robot of everyone) {
      const found = foraging.genesAt(robot, when);
      if (found !== null) counts[found[4][i]] += 1;
    }
    const told = counts.map((count, band) => `${GENES[i].bands[band][0]} ${count}`).join(', ');
    if (own.told !== told) tellStrip(own, told);
    own.told = told;
  });
}

// ---- Food over time.

/**
 * Bars of food: each is so many seconds wide.
 * @type {{ width: number, counts: number[] }}
 */
let bars = { width: 250, counts: [] };

/**
 * The bar that a time belongs to.
 * @param {number} seconds
 */
const barOf = (seconds) => Math.min(Math.max(0, Math.floor((seconds - 0.1) / bars.width)), bars.counts.length - 1);
/** @param {number} bar */
const barText = (bar) => `${bars.counts[bar]} in ${bar * bars.width} to ${(bar + 1) * bars.width} s`;

function buildChart() {
  const { record: { last, every, lines, poses }, broughtByAll } = foraging;
  // Short runs have shorter bars.
  const width = last >= 1000 ? 250 : Math.max(every, rounded(last, 12));
  bars = { width, counts: new Array(Math.max(1, Math.ceil(last / width - 1e-9))).fill(0) };
  for (let line = 0; line < lines; line++) {
    bars.counts[barOf(poses.times[line] / 10)] += broughtByAll[line] - (line > 0 ? broughtByAll[line - 1] : 0);
  }
  const most = Math.max(1, ...bars.counts);
  chart.span(bars.counts.length * width, 0, most);
  // Food is counted.
  chart.view.step = Math.max(1, chart.view.step);
  chart.view.most = Math.ceil(most / chart.view.step) * chart.view.step;
  element('chart-title', HTMLElement).textContent = `Food brought per ${width} s`;
  chart.canvas.setAttribute('aria-label', `Food brought: ${bars.counts.map((_, i) => barText(i)).join(', ')}`);
}

/** @param {number} when */
function drawChart(when) {
  const { pen, view } = chart;
  const { colours } = stage.theme;
  const { record, brought, broughtByAll } = foraging;
  const { followed } = player;
  chart.ground();
  const { line } = record.locate(when);
  /** @param {number} at */
  const byAll = (at) => (at < 0 ? 0 : broughtByAll[at]);
  /** @param {number} at */
  const byFollowed = (at) => (at < 0 ? 0 : brought[at * record.robots + followed]);
  bars.counts.forEach((count, i) => {
    const x = chart.x(i * bars.width) + 1.5;
    const width = Math.max(1, chart.x((i + 1) * bars.width) - x - 1.5);
    const from = i > 0 ? record.lineAt(i * bars.width) : -1;
    const to = Math.min(line, record.lineAt((i + 1) * bars.width));
    /** @param {number} height @param {string} colour */
    const bar = (height, colour) => {
      pen.fillStyle = colour;
      pen.fillRect(x, chart.y(height), width, chart.base - chart.y(height));
    };
    bar(count, colours['food-faint']);
    if (record.lines === 0 || to <= from) return;
    bar(byAll(to) - byAll(from), colours.food);
    if (followed >= 0) bar(byFollowed(to) - byFollowed(from), colours.link);
  });
  for (const [cycle] of foraging.data.lights.slice(1)) {
    if (cycle / 10 > view.whole) continue;
    const x = Math.round(chart.x(cycle / 10)) + 0.5;
    pen.setLineDash([4, 3]);
    chart.upright(x, colours['lamp-edge'], 1);
    pen.setLineDash([]);
    pen.textAlign = x > 0.6 * view.wide ? 'right' : 'left';
    pen.fillStyle = colours['lamp-text'];
    pen.fillText('light moves', x + (pen.textAlign === 'left' ? 4 : -4), view.top - 8);
  }
  chart.cursor(when);
}

// ---- Words around the arena.

function buildLegend() {
  for (const { short = '', colour, front } of fixed.acts) {
    if (!front) continue;
    legendEntry(`<circle r="7.5" fill="${colour}" stroke="${front}"/><path d="M7 0L3.2 3.4V-3.4Z" fill="${front}"/>`, short);
  }
  const grain = 'fill="var(--food)" stroke="var(--food-edge)"';
  legendEntry(`<circle cx="-4.8" r="3.6" ${grain}/><circle cx="2" r="6" fill="var(--object)"/>`, 'with food');
  if (!fixed.whole) return;
  const around = 'fill="var(--food)" fill-opacity=".3" stroke="var(--food-edge)" stroke-opacity=".55"';
  legendEntry(`<circle r="8" ${around}/><circle r="3" ${grain}/>`, 'food');
  legendEntry(MESSAGE_PICTURE, 'heard');
}

function buildLights() {
  const { data, record: { first, last } } = foraging;
  const lights = element('lights', HTMLElement);
  lights.replaceChildren();
  if (last <= first) return;
  data.lights.forEach(([cycle, where], i) => {
    const from = Math.max(cycle / 10, first);
    const to = Math.min(i + 1 < data.lights.length ? data.lights[i + 1][0] / 10 : last, last);
    if (to <= from) return;
    const textContent = where === 'none' ? 'no light' : `light ${LIGHTS[where]}`;
    const part = made('span', lights, { textContent, className: where });
    part.style.left = `${(100 * (from - first)) / (last - first)}%`;
    part.style.width = `${(100 * (to - from)) / (last - first)}%`;
  });
}

/** What was told last. */
let told = { light: '', robot: '' };

/** @param {number} when */
function showWords(when) {
  const { now, next } = foraging.lightAt(when);
  const is = now === 'none' ? 'There is no light' : `The light is ${LIGHTS[now]}`;
  let then = '';
  if (next !== null) {
    const what = next.where === 'none' ? 'it will be off' : `${now === 'none' ? 'one' : 'it'} will be ${LIGHTS[next.where]}`;
    then = `; in ${foraging.record.clock(Math.ceil(next.at - when))} ${what}`;
  }
  set(element('light', HTMLElement), 'textContent', `${is}${then}.`);
  if (told.light !== '' && told.light !== is) say(`${is} now.`);
  const text = robotText(when);
  if (told.robot !== text) {
    const box = element('robot', HTMLElement);
    const [bold, rest] = text.split('|');
    box.replaceChildren();
    made('b', box, { textContent: bold });
    box.append(rest);
  }
  told = { light: is, robot: text };
}

/**
 * The followed robot in words, bold up to the bar.
 * @param {number} when
 */
function robotText(when) {
  const { record, data } = foraging;
  const { followed } = player;
  if (record.lines === 0) return `|${data.live ? 'No robot has said anything yet.' : 'There is nothing to play.'}`;
  if (followed < 0) return '|Click a robot, or its number in the table, to follow it.';
  const { line } = record.locate(when);
  const at = line * record.robots + followed;
  const others = foraging.pairs(line).filter(([hearer]) => hearer === followed).map(([, other]) => names[other]);
  const { name, front } = foraging.act(followed, line);
  const parts = [front ? `${name}, ${foraging.carries(followed, line) ? 'with food' : 'without food'}` : name];
  const many = others.length > 6 ? `${others.length} others` : others.join(', ');
  if (data.whole) parts.push(others.length === 0 ? 'it heard nobody' : `it heard ${many}`);
  if (data.problems && foraging.problem[at] > 0) parts.push(data.problems[foraging.problem[at]]);
  if (foraging.earned[at] !== UNKNOWN) parts.push(`fitness in this interval ${(foraging.earned[at] / 10).toFixed(1)}`);
  return `Robot ${names[followed]} |${parts.join('; ')}.`;
}

function show() {
  const { time } = player;
  drawArena(time);
  showTable(time);
  drawChart(time);
  showWords(time);
  player.showClock();
}

// ---- What is new, while a fleet lives.

let arrived = performance.now();

/** @param {Facts} fresh */
function take(fresh) {
  if (fresh.written === foraging.data.written) return;
  arrived = performance.now();
  // Who looks at the newest line sees the next one; who looks back stays there.
  const isNewest = player.time >= foraging.record.last;
  foraging = new Foraging({ ...foraging.data, ...fresh });
  player.replace(foraging.record, isNewest ? foraging.record.last : player.time);
  buildLights();
  buildChart();
  chart.fit();
}

function showNews() {
  const silence = Math.floor((performance.now() - arrived) / 1000);
  const back = player.time < foraging.record.last ? ' You are looking back: End shows what is now.' : '';
  const silent = `Nothing new for ${silence} s: robots stand unless \u201coneiro fleet start\u201d runs.`;
  set(element('news', HTMLElement), 'textContent', (foraging.data.end || (silence >= SILENCE ? silent : 'Live.')) + back);
}

/** @param {string} script */
function look(script) {
  // Another address each time, so that nothing old is taken from memory.
  const loaded = made('script', document.body, { src: `${script}?${Date.now()}` });
  const done = () => {
    loaded.remove();
    showNews();
    setTimeout(() => look(script), 1000);
  };
  loaded.onload = done;
  loaded.onerror = done;
}

element('note', HTMLElement).textContent = evolves
  ? 'Each mark is a gene within the bands of what it means: the light is opposite the nest, there is none, or it is '
    + 'over the nest (in bold: as it is now); flee the light, search at random, seek the light. Filled marks are in use.'
  : 'These robots do not evolve: they have no genes.';
buildLegend();
buildLights();
buildChart();
// `take` is for the script with newer data. `drawn` is for tests: it draws a time, and tells where robots and food were drawn,
// mm and turns, taken back from the canvas, and what colour the canvas has where a robot's side should be.
Object.assign(window, {
  oneiro: {
    take,
    /** @param {number} when */
    drawn: (when) => ({ ...stage.stop(when), food: putFood }),
  },
});
stage.begin(!fixed.live);
if (fixed.live) look(fixed.live);
