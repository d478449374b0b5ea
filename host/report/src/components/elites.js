// The page of an archive of elites: its map, and the episode of the chosen one. A fragment such as #cell=1275 opens the page with that
// cell's elite, instead of the best one.
import { shortened } from './chart.js';
import { element, isCalm, made, say, set, setAttribute } from './dom.js';
import { bytes, facts } from './facts.js';
import { PoseRecord, unpacked } from './record.js';
import { drawRobot } from './robots.js';
import { Stage } from './stage.js';
import { Tiles } from './tiles.js';
import { drawTrails } from './trails.js';

/** @type {import('./facts.js').ElitesFacts} */
const data = facts();
const poses = unpacked(data);
const fitness = new Float32Array(bytes(data.fitness));
/** Where each episode's poses begin. */
const begins = data.lengths.reduce((all, length) => [...all, all[all.length - 1] + length], [0]);

/**
 * Poses of an elite's episode.
 * @param {number} elite
 */
function recordOf(elite) {
  const [from, to] = [begins[elite], begins[elite + 1]];
  return new PoseRecord({
    names: [Number(data.rows[elite][0])],
    times: Array.from({ length: to - from }, (_, line) => line * data.every),
    unit: poses.unit,
    xs: poses.xs.subarray(from, to),
    ys: poses.ys.subarray(from, to),
    headings: poses.headings.subarray(from, to),
  });
}

let chosen = data.best;
/** @param {number} line */
const fitnessAt = (line) => fitness[begins[chosen] + line];

/** @type {Stage} */
const stage = new Stage(recordOf(chosen), data.body, {
  fit: () => arena.fitAround(data.view),
  show,
  told: (seconds) => {
    const { record } = player;
    const line = record.locate(seconds).line;
    return record.lines > 0 ? `${record.clock(record.timeOf(line))}: ${shortened(fitnessAt(line))}` : 'no cycle';
  },
});
const { arena, chart, player } = stage;

function drawArena() {
  const { moment, record } = player;
  arena.clear();
  arena.ground(data.arena);
  arena.scale(0.2 * (data.view.right - data.view.left));
  const pose = record.pose(0, moment);
  if (!pose) return;
  drawTrails(arena, record, moment, { robots: [0], seconds: record.last, colour: arena.marks.link, width: 2.4, strength: 0.9 });
  drawRobot(arena, pose, { body: data.body, name: record.names[0], act: { name: '', ...data.look }, followed: false });
}

function drawChart() {
  const { record, moment } = player;
  const { faint, link } = stage.theme.colours;
  chart.ground();
  chart.curve(record, record.lines - 1, fitnessAt, faint, 1.5);
  if (record.lines > 0) chart.curve(record, moment.line, fitnessAt, link, 2.4);
  chart.cursor(player.time);
}

function show() {
  const { moment, record } = player;
  drawArena();
  drawChart();
  const now = record.lines > 0 ? `fitness if the episode ended now: ${shortened(fitnessAt(moment.line))}`
    : 'the episode ended before its first cycle';
  set(element('light', HTMLElement), 'textContent', `Elite of cell ${record.names[0]}: ${now}`);
  player.showClock();
}

/**
 * An elite's values in words.
 * @param {number} elite
 */
const words = (elite) => data.columns.map((name, i) => `${name} ${data.rows[elite][i]}`).join(', ');

/**
 * The ranges of a cell of a grid; nothing for others.
 * @param {number} cell
 */
function rangesOf(cell) {
  if (!data.grid) return '';
  let rest = cell;
  const ranges = [...data.axes].reverse().map(({ name, least, greatest, cells }) => {
    const at = rest % cells;
    rest = Math.floor(rest / cells);
    const ends = [at, at + 1].map((place) => shortened(least + ((greatest - least) * place) / cells));
    return `${name} ${ends.join(' to ')}`;
  });
  return `: ${ranges.reverse().join(', ')}`;
}

const tiles = new Tiles(data.centres, {
  choose: (elite) => choose(elite, true),
  hover: (tile) => {
    const hovered = tile && (tile.elite < 0 ? `cell ${tile.cell}${rangesOf(tile.cell)}: no elite` : words(tile.elite));
    set(element('cell', HTMLElement), 'textContent', hovered || words(chosen));
  },
  told: words,
});

const table = element('table', HTMLTableElement);
const head = made('tr', made('thead', table));
data.columns.forEach((name) => made('th', head, { textContent: name, scope: 'col' }));
const body = made('tbody', table);
const rows = data.rows.map((values, elite) => {
  const row = made('tr', body);
  const button = made('button', made('th', row, { scope: 'row' }), { type: 'button', className: 'who', textContent: values[0] });
  button.setAttribute('aria-label', `Play the elite of cell ${values[0]}`);
  values.slice(1).forEach((value) => made('td', row, { textContent: value }));
  row.addEventListener('click', () => choose(elite, true));
  return { row, button };
});

/** @param {number} elite @param {boolean} plays */
function choose(elite, plays) {
  const before = rows[chosen];
  before.row.className = '';
  setAttribute(before.button, 'aria-pressed', 'false');
  chosen = elite;
  rows[elite].row.className = 'followed';
  setAttribute(rows[elite].button, 'aria-pressed', 'true');
  tiles.show(elite);
  element('which', HTMLElement).textContent = data.rows[elite][0];
  element('cell', HTMLElement).textContent = words(elite);
  // Without motion, the whole path is shown.
  player.replace(recordOf(elite), isCalm() ? Infinity : 0);
  const own = fitness.subarray(begins[elite], begins[elite + 1]);
  const [low, high] = [own.reduce((a, b) => Math.min(a, b), 0), own.reduce((a, b) => Math.max(a, b), 0)];
  chart.view.left = 56;
  chart.span(player.record.last, low, high);
  chart.canvas.setAttribute('aria-label', `Fitness over time, ${shortened(low)} to ${shortened(high)}`);
  if (!plays) return;
  say(words(elite));
  if (!isCalm()) player.play(true);
}

const asked = new URLSearchParams(location.hash.slice(1)).get('cell');
const opened = data.rows.findIndex(([cell]) => cell === asked);
choose(opened >= 0 ? opened : data.best, false);
// For tests: `drawn` draws a time, and tells where the robot was drawn, mm and turns, taken back from the canvas.
Object.assign(window, {
  oneiro: {
    /** @param {number} when */
    drawn: (when) => ({ ...stage.stop(when), lines: player.record.lines }),
  },
});
stage.begin();
