// Plays what a foraging swarm did, or shows what a fleet does: what player.js leaves to it. What each array holds stands in swarm.rs.
// While a fleet lives, a script beside the page brings newer data every second.

const FLOOR = '#f5f3ee';
const FOOD = '#93b94a';
const FOOD_EDGE = '#55741c';
const ENCOUNTER = '#8a3fa0';
const LIGHTS = { over: 'over the nest', none: 'off', opposite: 'opposite the nest' };
// An age or a fitness that is unknown.
const UNKNOWN = 65535;
// Seconds without anything new after which a page that shows a fleet says so.
const SILENCE = 3;
// Seconds before the light moves in which its next place is shown.
const NOTICE = 60;

const { acts } = data;
let states, earned, ages, problem, foodXs, foodYs, heard;
let items;
// Where the pairs of each line begin, and food brought up to it by each robot and in all.
let heardFrom, brought, broughtByAll;

function unpack(fresh) {
  unpackPoses(fresh);
  states = new Uint16Array(bytes(data.state));
  earned = new Uint16Array(bytes(data.earned));
  ages = new Uint16Array(bytes(data.age || ''));
  problem = new Uint16Array(bytes(data.problem || ''));
  foodXs = new Int16Array(bytes(data.food_x));
  foodYs = new Int16Array(bytes(data.food_y));
  heard = new Uint16Array(bytes(data.heard));
  items = lines > 0 ? foodXs.length / lines : 0;
  heardFrom = new Uint32Array(lines + 1);
  brought = new Uint16Array(lines * robots);
  broughtByAll = new Uint32Array(lines);
  for (let line = 0, at = 0; line < lines; line++) {
    heardFrom[line] = at + 1;
    at += 1 + heard[at];
    heardFrom[line + 1] = at + 1;
    let all = line > 0 ? broughtByAll[line - 1] : 0;
    for (let i = 0; i < robots; i++) {
      const own = states[line * robots + i] >> 5;
      brought[line * robots + i] = own + (line > 0 ? brought[(line - 1) * robots + i] : 0);
      all += own;
    }
    broughtByAll[line] = all;
  }
}

unpack({});
time = first;

const act = (robot, line) => acts[states[line * robots + robot] & 15];
const carries = (robot, line) => ((states[line * robots + robot] >> 4) & 1) === 1;

function lightAt(when) {
  let now = data.lights[0][1];
  let next = null;
  for (const [cycle, where] of data.lights.slice(1)) {
    // Half a cycle of room for rounding.
    if (when * 10 + 0.5 >= cycle) now = where;
    else next = next || { at: cycle / 10, where };
  }
  if (next && next.at > last) next = null;
  return { now, next };
}

function genesAt(robot, when) {
  let found = null;
  for (const change of data.genes[robot] || []) {
    if (change[0] <= when * 10 + 0.5) found = change;
    else break;
  }
  return found;
}

// ---- The arena.

const lampGap = Math.min(data.lamp, 0.4 * data.arena);

function fit() {
  const lit = data.lights.some(([, where]) => where !== 'none');
  const half = { x: data.arena * 1.04 + (lit ? lampGap + 0.14 * data.arena : 0), y: data.arena * 1.04 };
  fitTo({ left: -half.x, right: half.x, bottom: -half.y, top: half.y });
}

const lampPlace = (where) => place((where === 'over' ? -1 : 1) * (data.arena + lampGap), 0);

function drawGround(light) {
  const [x, y] = place(0, 0);
  const radius = data.arena * view.scale;
  pen.save();
  disc(x, y, radius);
  pen.fillStyle = FLOOR;
  pen.fill();
  pen.clip();
  if (light.now !== 'none') {
    const [lampX, lampY] = lampPlace(light.now);
    const reach = (2 * data.arena + lampGap) * view.scale;
    const glow = pen.createRadialGradient(lampX, lampY, 0, lampX, lampY, reach);
    for (let i = 0; i <= 10; i++) {
      const metres = ((i / 10) * reach) / view.scale / 1000;
      const strength = 0.62 * Math.exp(-data.decay * metres) * (1 - i / 10);
      glow.addColorStop(i / 10, `rgba(255, 196, 60, ${strength.toFixed(4)})`);
    }
    pen.fillStyle = glow;
    pen.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
  }
  const [nestX, nestY] = place(-data.arena, 0);
  disc(nestX, nestY, data.nest * view.scale);
  pen.fillStyle = 'rgba(88, 130, 200, 0.2)';
  pen.fill();
  pen.lineWidth = 1.5;
  pen.strokeStyle = '#6f92c9';
  pen.setLineDash([6, 4]);
  pen.stroke();
  pen.setLineDash([]);
  pen.restore();
  pen.lineWidth = 4;
  pen.strokeStyle = INK;
  disc(x, y, radius + 2);
  pen.stroke();
  const small = Math.max(10, Math.min(13, 0.02 * view.width));
  const inside = data.arena - Math.min(0.5 * data.nest, data.arena);
  words('nest', ...place(-inside, 0), small, '#3d5f96', 600);
  return small;
}

function drawLamp(light, small, when) {
  if (light.now !== 'none') {
    const [x, y] = lampPlace(light.now);
    const size = Math.max(5, 26 * view.scale);
    drawSun(x, y, size);
    const leaves = light.next && light.next.at - when <= NOTICE && light.next.where === 'none';
    const text = leaves ? `off in ${Math.ceil(light.next.at - when)} s` : 'light';
    words(text, x, y + 1.8 * size + small, small, '#7a5400', 600);
  }
  if (light.next && light.next.where !== 'none' && light.next.at - when <= NOTICE) {
    const [x, y] = lampPlace(light.next.where);
    const size = Math.max(5, 26 * view.scale);
    disc(x, y, 1.25 * size);
    pen.strokeStyle = '#a87400';
    pen.lineWidth = 1.6;
    pen.setLineDash([4, 3]);
    pen.stroke();
    pen.setLineDash([]);
    words(`in ${Math.ceil(light.next.at - when)} s`, x, y + 1.8 * size + small, small, '#7a5400', 600);
  }
}

function drawFood(line, when) {
  for (let item = 0; item < items; item++) {
    const at = line * items + item;
    // Food that was just put there grows in a moment.
    const before = at - items;
    const isNew = before >= 0 && (foodXs[before] !== foodXs[at] || foodYs[before] !== foodYs[at]);
    const grown = isNew && playing && !calm.matches ? Math.min(1, 0.3 + (when - timeOf(line)) / every) : 1;
    pen.save();
    pen.translate(...place(foodXs[at] * data.unit, foodYs[at] * data.unit));
    const { x, y } = standing();
    put.food.push([x, y]);
    disc(0, 0, data.food * view.scale * grown);
    pen.fillStyle = 'rgba(147, 185, 74, 0.3)';
    pen.fill();
    pen.strokeStyle = 'rgba(85, 116, 28, 0.55)';
    pen.lineWidth = 1;
    pen.stroke();
    disc(0, 0, Math.max(3, 13 * view.scale));
    pen.fillStyle = FOOD;
    pen.fill();
    pen.strokeStyle = FOOD_EDGE;
    pen.lineWidth = 1.2;
    pen.stroke();
    pen.restore();
  }
}

// How long, in the swarm's seconds, things flash: long enough to be seen at any speed.
const flash = () => (playing ? Math.max(1.2, 0.3 * speed) : 1);

function eachFlash(where, when, draw) {
  const life = flash();
  for (let line = where.line; line >= 0; line--) {
    const age = (when - timeOf(line)) / life;
    if (age >= 1) break;
    draw(line, calm.matches ? 1 : 1 - Math.max(age, 0));
  }
}

function drawEncounters(where, when, poses) {
  pen.strokeStyle = ENCOUNTER;
  pen.lineCap = 'round';
  eachFlash(where, when, (line, strength) => {
    for (const ours of followed < 0 ? [false] : [false, true]) {
      pen.globalAlpha = strength * (followed < 0 || ours ? 0.75 : 0.2);
      pen.lineWidth = ours ? 3 : 2;
      pen.beginPath();
      for (let at = heardFrom[line]; at < heardFrom[line + 1] - 1; at++) {
        const [hearer, other] = [heard[at] >> 8, heard[at] & 255];
        if (followed >= 0 && (hearer === followed || other === followed) !== ours) continue;
        if (!poses[hearer] || !poses[other]) continue;
        pen.moveTo(...place(poses[hearer].x, poses[hearer].y));
        pen.lineTo(...place(poses[other].x, poses[other].y));
      }
      pen.stroke();
    }
  });
  pen.globalAlpha = 1;
}

function drawRobot(robot, at, line) {
  drawBody(robot, at, act(robot, line), (radius) => {
    if (!carries(robot, line)) return;
    disc(-0.95 * radius, 0, Math.max(3, 0.46 * radius));
    pen.fillStyle = FOOD;
    pen.fill();
    pen.strokeStyle = FOOD_EDGE;
    pen.lineWidth = 1.4;
    pen.stroke();
  });
}

function drawArena(when) {
  clear();
  put.food = [];
  const light = lightAt(when);
  const small = drawGround(light);
  drawLamp(light, small, when);
  drawScale(small, 0.35 * data.arena);
  if (lines === 0) return;
  const where = locate(when);
  const everyone = Array.from({ length: robots }, (_, robot) => robot);
  drawFood(where.line, when);
  drawTrails(where, TRAIL, everyone, INK, Math.max(1.4, 5 * view.scale), 0.3);
  const poses = everyone.map((robot) => pose(robot, where));
  if (followed >= 0) {
    drawTrails(where, LONG_TRAIL, [followed], FOLLOWED, 2.4, 0.8);
  }
  if (poses[followed]) {
    disc(...place(poses[followed].x, poses[followed].y), data.range * view.scale);
    pen.strokeStyle = 'rgba(138, 63, 160, 0.45)';
    pen.lineWidth = 1.2;
    pen.setLineDash([3, 5]);
    pen.stroke();
    pen.setLineDash([]);
  }
  drawEncounters(where, when, poses);
  const present = everyone.filter((robot) => poses[robot]);
  for (const robot of present) drawRobot(robot, poses[robot], where.line);
  eachFlash(where, when, (line, strength) => {
    for (const robot of present) {
      const count = states[line * robots + robot] >> 5;
      if (count === 0) continue;
      const [x, y] = place(poses[robot].x, poses[robot].y);
      const radius = data.body * view.scale;
      pen.globalAlpha = strength;
      disc(x, y, radius * (1.5 + (calm.matches ? 0 : 1 - strength)));
      pen.strokeStyle = FOOD_EDGE;
      pen.lineWidth = 3;
      pen.stroke();
      words(`+${count}`, x, y - 1.7 * radius - 8, Math.max(12, 0.9 * radius), '#46611a', 700);
      pen.globalAlpha = 1;
    }
  });
}

// ---- The robots' table.

const evolves = data.genes.length > 0;
// Whether robots report themselves, and may fall silent.
const reports = 'age' in data;
const GENES = [
  { name: 'S0', about: 'what its simulator assumes of the light', kind: 'scenario',
    bands: [['opposite the nest', 'opp.'], ['none', 'none'], ['over the nest', 'over']] },
  { name: 'G0', about: 'what it does with food', kind: 'acts',
    bands: [['flees the light', 'flee'], ['searches at random', 'rand.'], ['seeks the light', 'seek']] },
  { name: 'G1', about: 'what it does without food', kind: 'acts',
    bands: [['flees the light', 'flee'], ['searches at random', 'rand.'], ['seeks the light', 'seek']] },
];
const SHORT = ['light', 'with food', 'without'];
const rows = [];
let all = null;
let scenarioNames = [];

function strip(row, gene, marks) {
  const cell = made('td', row, { className: 'gene' });
  const box = made('div', cell, { className: `strip ${gene.kind}` });
  box.setAttribute('role', 'img');
  return { box, marks: Array.from({ length: marks }, () => made('s', box, { hidden: true })), told: '' };
}

function foodCell(row) {
  const box = made('div', made('td', row, { className: 'food' }));
  return { count: made('b', box), bar: made('u', box), shown: '' };
}

function buildTable() {
  const table = element('robots');
  table.className = reports ? 'reports' : '';
  const head = made('tr', made('thead', table));
  const columns = evolves ? GENES : [];
  made('th', head, { textContent: 'Robot', scope: 'col' });
  made('th', head, { textContent: 'Does', scope: 'col', className: 'does' });
  if (reports) made('th', head, { textContent: 'Heard', scope: 'col', title: 'how long ago it said anything' });
  columns.forEach((gene, i) => {
    const cell = made('th', head, { scope: 'col', className: 'gene', title: gene.about });
    cell.append(`${gene.name} `);
    made('small', cell, { textContent: SHORT[i] });
    const names = made('div', cell, { className: 'names' });
    const spans = gene.bands.map(([long, short]) => made('span', names, { textContent: short, title: long }));
    if (i === 0) scenarioNames = spans;
  });
  made('th', head, { textContent: 'Food', scope: 'col', className: 'food' });
  const body = made('tbody', table);
  if (robots > 1) {
    const row = made('tr', body, { className: 'all' });
    made('th', row, { textContent: 'All', scope: 'row' });
    made('td', row, { className: 'does' });
    if (reports) made('td', row);
    // Many marks are fainter, so that it shows where they are close.
    row.style.setProperty('--faint', Math.min(0.5, Math.max(0.1, 5 / robots)));
    all = { strips: columns.map((gene) => strip(row, gene, robots)), food: foodCell(row) };
  }
  for (let robot = 0; robot < robots; robot++) {
    const row = made('tr', body);
    const { button, dot } = followButton(robot, made('th', row, { scope: 'row' }));
    const cell = made('td', row, { className: 'does' });
    const does = made('span', cell);
    const reported = reports ? { problems: made('small', cell), age: made('td', row, { className: 'age' }) } : {};
    const strips = columns.map((gene) => strip(row, gene, 1));
    rows.push({ row, button, dot, does, strips, food: foodCell(row), ...reported });
  }
  element('note').textContent = evolves
    ? 'Each mark is a gene within the bands of what it means: the light is opposite the nest, there is none, or it is '
      + 'over the nest (in bold: as it is now); flee the light, search at random, seek the light. Dark marks are in use.'
    : 'These robots do not evolve: they have no genes.';
}

function ageText(robot, line) {
  const age = ages[line * robots + robot];
  return age === UNKNOWN ? 'never' : `${(age / 10).toFixed(1)} s ago`;
}

function showFood(cell, count, most) {
  const shown = `${count}/${most}`;
  if (cell.shown === shown) return;
  cell.shown = shown;
  cell.count.textContent = count;
  cell.bar.style.backgroundSize = `${most > 0 ? (100 * count) / most : 0}% 100%`;
}

function showTable(when) {
  if (lines === 0) return;
  const { line } = locate(when);
  const light = lightAt(when).now;
  const most = Math.max(...brought.subarray((lines - 1) * robots));
  scenarioNames.forEach((span, i) => {
    set(span, 'className', ['opposite', 'none', 'over'][i] === light ? 'true' : '');
  });
  rows.forEach(({ row, button, dot, does, strips, food, problems, age }, robot) => {
    const { short, colour } = act(robot, line);
    const loaded = carries(robot, line);
    showButton({ row, button, dot }, robot, colour);
    const ring = loaded ? `0 0 0 1.5px #ffffff, 0 0 0 4px ${FOOD}` : 'none';
    if (dot.dataset.ring !== ring) {
      dot.dataset.ring = ring;
      dot.style.boxShadow = ring;
    }
    set(does, 'textContent', short);
    showFood(food, brought[line * robots + robot], most);
    if (reports) {
      set(age, 'textContent', ageText(robot, line));
      const text = data.problems[problem[line * robots + robot]];
      set(problems, 'textContent', text);
      set(problems, 'title', text);
    }
    if (!evolves) return;
    const genes = genesAt(robot, when);
    strips.forEach((own, i) => {
      const used = genes !== null && (i === 0 || (i === 1) === loaded);
      const told = genes === null ? 'none yet' : `${genes[i + 1]}/${used}`;
      if (own.told === told) return;
      own.told = told;
      const band = genes === null ? '' : GENES[i].bands[genes[4][i]][0];
      own.box.setAttribute('aria-label', genes === null ? 'none yet' : `${genes[i + 1].toFixed(2)}, ${band}`);
      own.box.title = genes === null ? 'none yet' : `${GENES[i].name} ${genes[i + 1].toFixed(2)}: ${band}`;
      for (const mark of all ? [own.marks[0], all.strips[i].marks[robot]] : own.marks) {
        mark.hidden = genes === null;
        if (genes !== null) mark.style.left = `${(100 * genes[i + 1]).toFixed(2)}%`;
      }
      own.marks[0].className = used ? 'used' : '';
    });
  });
  if (!all) return;
  set(all.food.count, 'textContent', String(broughtByAll[line]));
  all.strips.forEach((own, i) => {
    const counts = [0, 0, 0];
    for (let robot = 0; robot < robots; robot++) {
      const genes = genesAt(robot, when);
      if (genes !== null) counts[genes[4][i]] += 1;
    }
    const told = counts.map((count, band) => `${GENES[i].bands[band][0]} ${count}`).join(', ');
    if (own.told === told) return;
    own.told = told;
    own.box.setAttribute('aria-label', told);
    own.box.title = told;
  });
}

// ---- Food over time.

const bars = { width: 250, counts: [] };

const barOf = (line) => Math.max(0, Math.floor((data.times[line] - 1) / (10 * bars.width)));

function buildChart() {
  // Short runs have shorter bars.
  bars.width = last >= 1000 ? 250 : Math.max(every, rounded(last, 12));
  bars.counts = new Array(Math.max(1, Math.ceil(last / bars.width - 1e-9))).fill(0);
  for (let line = 0; line < lines; line++) {
    bars.counts[barOf(line)] += broughtByAll[line] - (line > 0 ? broughtByAll[line - 1] : 0);
  }
  bars.most = Math.max(1, ...bars.counts);
  chartView.whole = bars.counts.length * bars.width;
  element('chart-title').textContent = `Food brought per ${bars.width} s`;
  const told = bars.counts.map((count, i) => `${count} in ${i * bars.width} to ${(i + 1) * bars.width} s`);
  chart.setAttribute('aria-label', `Food brought: ${told.join(', ')}`);
}

function drawChart(when) {
  const p = chartPen;
  const base = chartBase();
  const step = Math.max(1, rounded(bars.most, 4));
  chartView.most = Math.ceil(bars.most / step) * step;
  drawLevels(step);
  const { line } = locate(when);
  const own = (robot, at) => (at < 0 ? 0 : brought[at * robots + robot]);
  const byAll = (at) => (at < 0 ? 0 : broughtByAll[at]);
  bars.counts.forEach((count, i) => {
    const x = chartX(i * bars.width) + 1.5;
    const width = Math.max(1, chartX((i + 1) * bars.width) - x - 1.5);
    const from = i > 0 ? lineAt(i * bars.width) : -1;
    const to = Math.min(line, lineAt((i + 1) * bars.width));
    const bar = (height, colour) => {
      p.fillStyle = colour;
      p.fillRect(x, chartY(height), width, base - chartY(height));
    };
    bar(count, '#e9eddf');
    if (lines > 0 && to > from) {
      bar(byAll(to) - byAll(from), FOOD);
      if (followed >= 0) bar(own(followed, to) - own(followed, from), FOLLOWED);
    }
  });
  drawTimes();
  for (const [cycle] of data.lights.slice(1)) {
    if (cycle / 10 > chartView.whole) continue;
    const x = Math.round(chartX(cycle / 10)) + 0.5;
    p.strokeStyle = '#a87400';
    p.setLineDash([4, 3]);
    p.beginPath();
    p.moveTo(x, chartView.top - 6);
    p.lineTo(x, base);
    p.stroke();
    p.setLineDash([]);
    p.textAlign = x > 0.6 * chartView.wide ? 'right' : 'left';
    p.fillStyle = '#7a5400';
    p.fillText('light moves', x + (p.textAlign === 'left' ? 4 : -4), chartView.top - 8);
  }
  drawNow(when);
}

// ---- Words around the arena.

function buildLegend() {
  acts.filter(({ marks }) => marks).forEach(({ short, colour, marks: [front] }) => {
    legendEntry(`<circle r="7.5" fill="${colour}"/><path d="M7 0L3.2 3.4V-3.4Z" fill="${front}"/>`, short);
  });
  const grain = `fill="${FOOD}" stroke="${FOOD_EDGE}"`;
  legendEntry(`<circle cx="-4.8" r="3.6" ${grain}/><circle cx="2" r="6" fill="#c9ccd3"/>`, 'with food');
  if (!data.whole) return;
  legendEntry(`<circle r="8" fill="#93b94a4d" stroke="#55741c8c"/><circle r="3" ${grain}/>`, 'food');
  legendEntry(`<path d="M-8 4L8 -4" stroke="${ENCOUNTER}" stroke-width="2.4" stroke-linecap="round"/>`, 'heard');
}

function buildLights() {
  const strip = element('lights');
  strip.replaceChildren();
  if (last <= first) return;
  data.lights.forEach(([cycle, where], i) => {
    const from = Math.max(cycle / 10, first);
    const to = Math.min(i + 1 < data.lights.length ? data.lights[i + 1][0] / 10 : last, last);
    if (to <= from) return;
    const text = where === 'none' ? 'no light' : `light ${LIGHTS[where]}`;
    const part = made('span', strip, { textContent: text, className: where });
    part.style.left = `${(100 * (from - first)) / (last - first)}%`;
    part.style.width = `${(100 * (to - from)) / (last - first)}%`;
  });
}

let told = { light: '', robot: '' };

function showWords(when) {
  const { now, next } = lightAt(when);
  const is = now === 'none' ? 'There is no light' : `The light is ${LIGHTS[now]}`;
  let then = '';
  if (next !== null) {
    const what = next.where === 'none' ? 'it will be off' : `${now === 'none' ? 'one' : 'it'} will be ${LIGHTS[next.where]}`;
    then = `; in ${clock(Math.ceil(next.at - when))} ${what}`;
  }
  set(element('light'), 'textContent', `${is}${then}.`);
  if (told.light !== '' && told.light !== is) say(`${is} now.`);
  told.light = is;

  const text = robotText(when);
  if (told.robot !== text) {
    told.robot = text;
    const box = element('robot');
    const [bold, rest] = text.split('|');
    box.replaceChildren();
    made('b', box, { textContent: bold });
    box.append(rest);
  }
  showClock(when);
}

function robotText(when) {
  if (lines === 0) return `|${data.live ? 'No robot has said anything yet.' : 'There is nothing to play.'}`;
  if (followed < 0) return '|Click a robot, or its number in the table, to follow it.';
  const { line } = locate(when);
  const at = line * robots + followed;
  const others = [];
  for (let pair = heardFrom[line]; pair < heardFrom[line + 1] - 1; pair++) {
    if (heard[pair] >> 8 === followed) others.push(names[heard[pair] & 255]);
  }
  const { name, marks } = act(followed, line);
  const parts = [marks ? `${name}, ${carries(followed, line) ? 'with food' : 'without food'}` : name];
  const many = others.length > 6 ? `${others.length} others` : others.join(', ');
  if (data.whole) parts.push(others.length === 0 ? 'it heard nobody' : `it heard ${many}`);
  if (reports && problem[at] > 0) parts.push(data.problems[problem[at]]);
  if (earned[at] !== UNKNOWN) parts.push(`fitness in this interval ${(earned[at] / 10).toFixed(1)}`);
  return `Robot ${names[followed]} |${parts.join('; ')}.`;
}

// ---- Playing.

function show() {
  drawArena(time);
  showTable(time);
  drawChart(time);
  showWords(time);
}

// ---- What is new, while a fleet lives.

let arrived = performance.now();

function take(fresh) {
  if (fresh.written === data.written) return;
  arrived = performance.now();
  // Who looks at the newest line sees the next one; who looks back stays there.
  const isNewest = time >= last;
  unpack(fresh);
  time = isNewest ? last : Math.max(time, first);
  spread();
  fitChart();
  ask();
}

function showNews() {
  const silence = Math.floor((performance.now() - arrived) / 1000);
  const back = time < last ? ' You are looking back: End shows what is now.' : '';
  const silent = `Nothing new for ${silence} s: robots stand unless \u201coneiro fleet start\u201d runs.`;
  const news = data.end || (silence >= SILENCE ? silent : 'Live.');
  set(element('news'), 'textContent', news + back);
}

function look() {
  const done = ({ target }) => {
    target.remove();
    showNews();
    setTimeout(look, 1000);
  };
  // Another address each time, so that nothing old is taken from memory.
  made('script', document.body, { src: `${data.live}?${Date.now()}`, onload: done, onerror: done });
}

// Fits what depends on how long the record is.
// Fits what depends on how long the record is.
function spread() {
  spreadTime();
  buildLights();
  buildChart();
}

// `take` is for the script with newer data. `drawn` is for tests: it draws a time, and tells where robots and food were drawn,
// mm and turns, taken back from the canvas, and what colour the canvas has where a robot's side should be.
window.oneiro = {
  take,
  drawn(when) {
    play(false);
    seek(when);
    drawArena(time);
    const colours = sideColours();
    return { time, robots: put.robots.map((robot, i) => ({ ...robot, colour: colours[i] })), food: put.food };
  },
};

buildLegend();
buildTable();
spread();
const isAt = begin();
if (data.live) look();
else if (!isAt && !calm.matches) play(true);
