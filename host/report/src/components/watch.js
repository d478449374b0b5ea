// The page of `oneiro watch`. The server sends a list of all that it watches whenever something has changed; the page then fetches pictures
// of what is selected, at most once a second. It keeps nothing of what it no longer shows: its memory stays the same however long a run is.
import { element, made } from './dom.js';
import { attach } from './svg-chart.js';

/**
 * @typedef {{ id: string, kind: 'run' | 'sweep' | 'fleet' | 'unreadable', directory: string, name?: string, seed?: string,
 *   state?: string, steps?: number, length?: number, best?: number | null, left?: number | null, problem?: string | null,
 *   version?: number, label?: string | null }} Source
 * @typedef {{ generation: number, individual: number, fitness: number | null, paths: string | null, archive: string | null }} Scene
 */

/** @type {Record<string, string>} */
const MARKS = { running: '\u25b6', unfinished: '\u25b6', done: '\u2713', stopped: '\u25a0', interrupted: '!', unreadable: '!' };
// Milliseconds between two fetches of a picture, and after which an episode that plays gives way to a newer one.
const PAUSE = 1000;
const LONGEST = 40000;

/** @param {string} id */
const part = (id) => element(id, HTMLElement);
const slider = element('generation', HTMLInputElement);
const newest = element('newest', HTMLInputElement);
const frame = element('episode', HTMLIFrameElement);
const progress = element('progress', HTMLProgressElement);

// Whoever has it may change the experiment; it lasts as long as this window.
const edit = new URLSearchParams(location.search).get('edit');
if (edit) sessionStorage.setItem('edit', edit);
// The secret was for the first request alone; the cookie replaces it.
if (location.search) history.replaceState(null, '', location.pathname);

/** The form's fields by key, with the experiment's values.
 * @type {Map<string, { input: HTMLInputElement, value: string }>} */
const inputs = new Map();
/** @type {Source[]} */
let sources = [];
let more = 0;
let selected = '';
// Whether the newest run is selected until the reader chooses.
let chosen = false;
// What is shown: of which source, and its version.
let drawn = '';
let fetched = -Infinity;
let busy = false;
// The episode in the frame, a newer one, and when the first began.
let playing = '';
/** @type {Scene | null} */
let waiting = null;
let began = 0;

/** @param {string} path */
async function text(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(await answer.text());
  return answer.text();
}

/** Text that may break within a key.
 * @param {string} text */
const breakable = (text) => text.replace(/[._]/g, '$&\u200b');

/** @param {number} seconds */
function duration(seconds) {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

const current = () => sources.find((source) => source.id === selected);

// ---- The list.

function showList() {
  const list = part('list');
  const scrolled = list.scrollTop;
  const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.id : undefined;
  list.replaceChildren();
  let heading = '';
  for (const source of sources) {
    const name = source.name || source.directory;
    if (name !== heading) made('h2', list, { textContent: name });
    heading = name;
    const button = made('button', list, { type: 'button', title: source.directory });
    button.dataset.id = source.id;
    if (source.id === selected) button.setAttribute('aria-current', 'true');
    const state = source.state || source.kind;
    const mark = made('span', button, { className: `state ${state}`, title: state, textContent: MARKS[state] || '\u00b7' });
    mark.setAttribute('role', 'img');
    mark.setAttribute('aria-label', state);
    // The directory's name, without what the heading says already.
    const own = (source.directory.split(/[\\/]/).pop() || '').replace(`${name}-`, '');
    const label = source.label ? breakable(`${source.label}, seed ${source.seed}`) : '';
    const run = own === source.seed ? `seed ${own}` : own;
    made('span', button, { textContent: source.kind !== 'run' ? source.kind : label || run });
    const best = typeof source.best === 'number' ? Number(source.best.toPrecision(4)).toString() : '';
    made('span', button, { className: 'best', textContent: best });
    if (state === 'running' || state === 'unfinished') {
      const bar = made('progress', button, { value: source.steps, max: source.length });
      bar.setAttribute('aria-hidden', 'true');
    }
    button.addEventListener('click', () => {
      chosen = true;
      select(source.id);
    });
    if (source.id === focused) button.focus();
  }
  if (more > 0) made('p', list, { textContent: `${more} older ones are not shown.` });
  list.scrollTop = scrolled;
}

/** @param {string} id */
function select(id) {
  if (id !== selected) {
    selected = id;
    drawn = '';
    playing = '';
    waiting = null;
    newest.checked = true;
    frame.removeAttribute('src');
    for (const id of ['curve', 'paths', 'archive', 'cells']) part(id).replaceChildren();
    for (const id of ['curve', 'scene', 'cells', 'none', 'paths-figure', 'archive-figure']) part(id).hidden = true;
    fetched = -Infinity;
  }
  showList();
  showHead();
  draw();
}

// ---- What is selected.

function showHead() {
  const source = current();
  if (!source) return;
  const label = source.label ? `: ${source.label}` : '';
  part('name').textContent = source.kind === 'run' ? `${source.name}, seed ${source.seed}${label}` : source.name || source.directory;
  part('use').hidden = source.kind !== 'run' || inputs.size === 0;
  const unit = source.kind === 'sweep' ? 'runs' : 'generations';
  const parts = [source.state || source.kind];
  if (source.length) parts.push(`${source.steps} of ${source.length} ${unit}`);
  if (typeof source.best === 'number') parts.push(`best ${Number(source.best.toPrecision(6))}`);
  if (source.left) parts.push(`about ${duration(source.left)} left`);
  parts.push(source.directory);
  if (source.problem) parts.push(source.problem);
  part('facts').textContent = parts.join(' \u00b7 ');
  progress.hidden = !source.length;
  progress.max = source.length || 1;
  progress.value = source.steps || 0;
  slider.max = String(Math.max(0, (source.steps || 1) - 1));
}

// Fetches what has changed, one thing after the other.
async function draw() {
  const source = current();
  if (!source || busy || drawn === `${source.id}/${source.version}`) return;
  const wait = fetched + PAUSE - performance.now();
  if (wait > 0) return;
  busy = true;
  fetched = performance.now();
  drawn = `${source.id}/${source.version}`;
  try {
    if (source.kind === 'run') await drawRun(source);
    if (source.kind === 'sweep') {
      const table = await text(`sweep/${source.id}`);
      if (source.id === selected) {
        part('cells').innerHTML = table;
        part('cells').hidden = false;
      }
    }
    if (source.kind === 'fleet' && playing !== source.id) {
      playing = source.id;
      part('scene').hidden = false;
      frame.src = `fleet/${source.id}/live.html`;
    }
    const links = await text(`links/${source.id}`);
    if (source.id === selected) part('links').innerHTML = links;
  } catch (problem) {
    part('connection').textContent = String(problem instanceof Error ? problem.message : problem);
  } finally {
    busy = false;
  }
}

/** @param {Source} source */
async function drawRun(source) {
  if (!source.steps) {
    part('none').hidden = false;
    part('none').textContent = 'No generation has finished yet.';
    // The first is fetched at once.
    fetched = -Infinity;
    return;
  }
  const curve = await text(`curve/${source.id}?width=${Math.round(part('left').clientWidth)}`);
  if (source.id !== selected) return;
  part('curve').innerHTML = curve;
  part('curve').hidden = false;
  attach(part('curve'));
  if (newest.checked) await showScene(source, null);
}

/** @param {Source} source @param {number | null} generation */
async function showScene(source, generation) {
  const query = generation === null ? '' : `?generation=${generation}`;
  /** @type {Scene | null} */
  const scene = JSON.parse(await text(`scene/${source.id}${query}`));
  if (source.id !== selected || newest.checked !== (generation === null)) return;
  part('scene').hidden = scene === null;
  part('none').hidden = scene !== null;
  part('none').textContent = source.state === 'done' ? 'There is no episode to show.'
    : 'There is no episode to show yet: this run does not record its individuals, or has not finished a generation.';
  if (!scene) return;
  for (const id of /** @type {const} */ (['paths', 'archive'])) {
    part(id).innerHTML = scene[id] || '';
    part(`${id}-figure`).hidden = !scene[id];
  }
  const fitness = scene.fitness === null ? 'NaN' : Number(scene.fitness.toPrecision(6));
  part('which').textContent = `${scene.generation}: individual ${scene.individual}, fitness ${fitness}`;
  if (newest.checked) slider.value = String(scene.generation);
  waiting = scene;
  // The first is played at once, and so is what the reader asks for.
  if (!playing || generation !== null) playNext();
}

function playNext() {
  const source = current();
  if (!source || !waiting) return;
  const next = `episode/${source.id}/${waiting.generation}`;
  waiting = null;
  if (next === playing) return;
  playing = next;
  began = performance.now();
  // Without an entry in the browser's history for each.
  if (frame.contentWindow && frame.getAttribute('src')) frame.contentWindow.location.replace(next);
  else frame.src = next;
}

// Whether the episode in the frame has come to its end.
function hasEnded() {
  if (performance.now() - began > LONGEST) return true;
  // An element of another window is no instance of this one's classes.
  const when = /** @type {HTMLInputElement | null} */ (frame.contentDocument?.getElementById('when') ?? null);
  return when !== null && when.value === when.max;
}

// ---- Events.

slider.addEventListener('input', () => {
  newest.checked = false;
  const wanted = slider.value;
  setTimeout(() => {
    const source = current();
    // A slider that still moves asks for nothing.
    if (source && slider.value === wanted) showScene(source, Number(wanted)).catch(() => {});
  }, 150);
});
part('full').hidden = !document.fullscreenEnabled;
part('full').addEventListener('click', () => frame.requestFullscreen());
newest.addEventListener('change', () => {
  const source = current();
  if (!source) return;
  playing = '';
  showScene(source, newest.checked ? null : Number(slider.value)).catch(() => {});
});

// ---- Another evolution.

async function buildForm() {
  const form = JSON.parse(await text('edit'));
  const secret = sessionStorage.getItem('edit');
  if (!form) return;
  part('edit').hidden = false;
  if (!secret) {
    part('form').textContent = 'To evolve again, open the address that oneiro watch --edit has printed: it says that you may.';
    return;
  }
  if (form.problem) {
    part('answer').textContent = form.problem;
    return;
  }
  part('fields').replaceChildren();
  inputs.clear();
  const all = [...form.fields, { key: 'seed', value: '1', unit: '', about: 'The same seed and values give the same bits.' }];
  for (const { key, value, unit, about } of all) {
    const label = made('label', part('fields'), { textContent: breakable(unit ? `${key} (${unit})` : key), title: about });
    const input = made('input', label, { value, spellcheck: false, autocomplete: 'off' });
    input.addEventListener('input', () => input.classList.toggle('changed', input.value !== value));
    inputs.set(key, { input, value });
  }
}

/** @param {string} path @param {object} wish */
async function post(path, wish) {
  const headers = { 'Content-Type': 'application/json', 'X-Oneiro-Edit': sessionStorage.getItem('edit') || '' };
  try {
    const answer = await fetch(path, { method: 'POST', headers, body: JSON.stringify(wish) });
    const { problem } = answer.ok ? await answer.json() : { problem: await answer.text() };
    part('answer').textContent = problem || '';
    return !problem;
  } catch {
    part('answer').textContent = 'oneiro watch has ended, or does not answer.';
    return false;
  }
}

part('form').addEventListener('submit', async (event) => {
  event.preventDefault();
  part('answer').textContent = 'Starting.';
  const set = [...inputs].filter(([key]) => key !== 'seed').map(([key, { input }]) => [key, input.value.trim()]);
  const seed = inputs.get('seed')?.input.value.trim() || '';
  const known = new Set(sources.map(({ id }) => id));
  // The new run is shown when it appears.
  if (!await post('evolve', { seed, set })) return;
  chosen = false;
  setTimeout(() => {
    if (sources.every(({ id }) => known.has(id))) part('answer').textContent = 'These values have evolved before: see the list.';
  }, 2000);
});
part('use').addEventListener('click', async () => {
  /** @type {Record<string, string>} */
  const values = JSON.parse(await text(`values/${selected}`));
  for (const [key, { input }] of inputs) {
    if (key in values) input.value = values[key];
    input.dispatchEvent(new Event('input'));
  }
  element('edit', HTMLDetailsElement).open = true;
  part('answer').textContent = 'These are the shown run\'s values.';
});
part('stop').addEventListener('click', () => post('stop', {}));
buildForm().then(showHead).catch(() => {});

const events = new EventSource('events');
events.addEventListener('message', (event) => {
  ({ sources, more } = JSON.parse(event.data));
  part('connection').textContent = sources.length === 0 ? 'Live: nothing has been written yet.' : 'Live.';
  if (!chosen || !current()) {
    const first = sources.find((source) => source.state === 'running' || source.state === 'unfinished') || sources[0];
    if (first && first.id !== selected) {
      select(first.id);
      return;
    }
  }
  showList();
  showHead();
  draw();
});
events.addEventListener('error', () => {
  part('connection').textContent = 'oneiro watch has ended, or does not answer. What is shown stays.';
});
addEventListener('resize', () => {
  drawn = '';
});
setInterval(() => {
  draw();
  if (waiting && newest.checked && hasEnded()) playNext();
}, 250);
