// Plays what a swarm did, or shows what a fleet does. Its data are in the element `replay`; what each array holds stands in
// swarm.rs. While a fleet lives, a script beside the page brings newer data every second.
// A fragment such as #t=754&robot=3 opens the page at that second, paused, following that robot.
(() => {
  'use strict';

  const INK = '#33363f';
  const SOFT_INK = '#74777f';
  const FLOOR = '#f5f3ee';
  const FOOD = '#93b94a';
  const FOOD_EDGE = '#55741c';
  const LAMP = '#f2b01e';
  const ENCOUNTER = '#8a3fa0';
  const FOLLOWED = '#23528f';
  const FONT = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";
  const LIGHTS = { over: 'over the nest', none: 'off', opposite: 'opposite the nest' };
  const SPEEDS = [1, 2, 5, 10, 20, 50, 100];
  // Position of a robot whose pose is unknown, and an age or a fitness that is.
  const NOWHERE = -32768;
  const UNKNOWN = 65535;
  // Seconds without anything new after which a page that shows a fleet says so.
  const SILENCE = 3;
  // Seconds of a trail, and of that of the robot that is followed.
  const TRAIL = 20;
  const LONG_TRAIL = 60;
  // Seconds before the light moves in which its next place is shown.
  const NOTICE = 60;

  const element = (id) => document.getElementById(id);
  const calm = matchMedia('(prefers-reduced-motion: reduce)');

  // Bytes as they were packed, little-endian, which every machine with a browser is.
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

  let data = JSON.parse(element('replay').textContent);
  const { names, acts } = data;
  const robots = names.length;
  let xs, ys, headings, states, earned, ages, problem, foodXs, foodYs, heard;
  let lines, items, every, first, last;
  // Where the pairs of each line begin, and food brought up to it by each robot and in all.
  let heardFrom, brought, broughtByAll;

  function unpack(fresh) {
    data = { ...data, ...fresh };
    xs = new Int16Array(bytes(data.x));
    ys = new Int16Array(bytes(data.y));
    headings = new Uint16Array(bytes(data.heading));
    states = new Uint16Array(bytes(data.state));
    earned = new Uint16Array(bytes(data.earned));
    ages = new Uint16Array(bytes(data.age || ''));
    problem = new Uint16Array(bytes(data.problem || ''));
    foodXs = new Int16Array(bytes(data.food_x));
    foodYs = new Int16Array(bytes(data.food_y));
    heard = new Uint16Array(bytes(data.heard));
    lines = data.times.length;
    items = lines > 0 ? foodXs.length / lines : 0;
    first = lines > 0 ? timeOf(0) : 0;
    last = lines > 0 ? timeOf(lines - 1) : 0;
    every = lines > 1 ? timeOf(1) - first : 1;
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

  // A line shows what is after its cycles.
  const timeOf = (line) => data.times[line] / 10;
  unpack({});

  let time = first;
  let playing = false;
  let speed = 10;
  let followed = -1;
  // What drawing a frame put where, for `drawn`.
  let put = { robots: [], sides: [], food: [] };

  // The last line up to a time, -1 before the first.
  function lineAt(when) {
    let [from, to] = [0, lines];
    while (from < to) {
      const middle = (from + to) >> 1;
      if (data.times[middle] <= when * 10 + 1e-6) from = middle + 1;
      else to = middle;
    }
    return from - 1;
  }

  // The line at or before a time, and the share of the way to the next.
  function locate(when) {
    const line = Math.max(lineAt(when), 0);
    if (line + 1 >= lines) return { line, share: 0 };
    const share = (when - timeOf(line)) / (timeOf(line + 1) - timeOf(line));
    return { line, share: share < 1e-9 ? 0 : share };
  }

  // Where a robot is: mm, and turns counter-clockwise; null if that is unknown. Between lines it goes straight and turns the
  // shorter way.
  function pose(robot, { line, share }) {
    const at = line * robots + robot;
    if (xs[at] === NOWHERE) return null;
    let x = xs[at];
    let y = ys[at];
    let heading = headings[at];
    const next = at + robots;
    if (share > 0 && xs[next] !== NOWHERE) {
      x += share * (xs[next] - x);
      y += share * (ys[next] - y);
      heading += share * (((headings[next] - heading + 98304) & 65535) - 32768);
    }
    return { x: x * data.unit, y: y * data.unit, heading: heading / 65536 };
  }

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

  function clock(seconds) {
    // Tenths where lines are closer than a second.
    const tenths = every % 1 === 0 ? 0 : 1;
    const whole = Math.floor(seconds * 10 ** tenths + 1e-6) / 10 ** tenths;
    const rest = (whole % 60).toFixed(tenths);
    return `${Math.floor(whole / 60)}:${rest.padStart(tenths === 0 ? 2 : 4, '0')}`;
  }

  // ---- The arena.

  const canvas = element('arena');
  const pen = canvas.getContext('2d');
  // From mm to the canvas's pixels, y up in the arena and down on the canvas.
  const view = { scale: 1, x: 0, y: 0, width: 1, height: 1, ratio: 1 };
  const lampGap = Math.min(data.lamp, 0.4 * data.arena);
  const place = (x, y) => [view.x + x * view.scale, view.y - y * view.scale];

  function fit() {
    const room = element('room');
    const lit = data.lights.some(([, where]) => where !== 'none');
    const half = { x: data.arena * 1.04 + (lit ? lampGap + 0.14 * data.arena : 0), y: data.arena * 1.04 };
    const width = Math.max(room.clientWidth, 120);
    let height = (width * half.y) / half.x;
    if (matchMedia('(min-width: 1081px)').matches) {
      // Controls stay in sight below.
      height = Math.min(height, Math.max(320, innerHeight - 298));
    } else {
      height = Math.min(height, Math.max(260, 0.8 * innerHeight));
    }
    view.ratio = devicePixelRatio || 1;
    view.width = width;
    view.height = Math.round(height);
    view.scale = Math.min(view.width / (2 * half.x), view.height / (2 * half.y));
    view.x = view.width / 2;
    view.y = view.height / 2;
    canvas.width = Math.round(view.width * view.ratio);
    canvas.height = Math.round(view.height * view.ratio);
    canvas.style.height = `${view.height}px`;
  }

  function disc(x, y, radius) {
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
  }

  // Text with a rim of the ground's colour, to be read on whatever is below it.
  function words(text, x, y, size, colour, weight = 400) {
    pen.font = `${weight} ${size}px ${FONT}`;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.lineJoin = 'round';
    pen.lineWidth = 3;
    pen.strokeStyle = 'rgba(255, 255, 255, 0.85)';
    pen.strokeText(text, x, y);
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
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
      pen.strokeStyle = LAMP;
      pen.lineWidth = 2;
      pen.lineCap = 'round';
      for (let ray = 0; ray < 8; ray++) {
        const turn = (ray / 8) * 2 * Math.PI;
        pen.beginPath();
        pen.moveTo(x + 1.35 * size * Math.cos(turn), y + 1.35 * size * Math.sin(turn));
        pen.lineTo(x + 1.8 * size * Math.cos(turn), y + 1.8 * size * Math.sin(turn));
        pen.stroke();
      }
      disc(x, y, size);
      pen.fillStyle = LAMP;
      pen.fill();
      pen.strokeStyle = '#a87400';
      pen.lineWidth = 1.2;
      pen.stroke();
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

  // What `drawn` tells: where the pen stands, taken back from pixels to mm.
  function standing() {
    const { scale, x, y, ratio } = view;
    const back = new DOMMatrix([scale * ratio, 0, 0, -scale * ratio, x * ratio, y * ratio]).inverse();
    const here = back.multiply(pen.getTransform());
    return { x: here.e, y: here.f, heading: Math.atan2(here.b, here.a) / (2 * Math.PI) };
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

  // Ways of the last seconds: all pieces of one age at once, since there may be many robots.
  function drawTrails(where, seconds, who, colour, width, strength) {
    const step = Math.max(1, Math.round(0.5 / every));
    const pieces = Math.ceil(seconds / (step * every));
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.lineCap = 'butt';
    let newer = who.map((robot) => pose(robot, where));
    for (let piece = 0; piece < pieces; piece++) {
      const line = where.line - piece * step - (where.share > 0 ? 0 : step);
      if (line < 0) break;
      const older = who.map((robot) => pose(robot, { line, share: 0 }));
      pen.globalAlpha = strength * (1 - piece / pieces);
      pen.beginPath();
      older.forEach((from, i) => {
        if (!from || !newer[i]) return;
        pen.moveTo(...place(newer[i].x, newer[i].y));
        pen.lineTo(...place(from.x, from.y));
      });
      pen.stroke();
      newer = older;
    }
    pen.globalAlpha = 1;
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

  function drawRobot(robot, { x, y, heading }, line) {
    const radius = data.body * view.scale;
    const { colour, marks } = act(robot, line);
    const [front, ink] = marks || ['#ffffff', '#ffffff'];
    pen.save();
    pen.translate(...place(x, y));
    pen.rotate(-2 * Math.PI * heading);
    const here = standing();
    put.robots.push({ name: names[robot], x: here.x, y: here.y, heading: here.heading });
    // On its side, where nothing else is painted on it.
    const { x: left, y: top } = pen.getTransform().transformPoint({ x: 0, y: 0.75 * radius });
    put.sides.push([left, top]);
    if (carries(robot, line)) {
      disc(-0.95 * radius, 0, Math.max(3, 0.46 * radius));
      pen.fillStyle = FOOD;
      pen.fill();
      pen.strokeStyle = FOOD_EDGE;
      pen.lineWidth = 1.4;
      pen.stroke();
    }
    disc(0, 0, radius);
    pen.fillStyle = colour;
    pen.fill();
    pen.strokeStyle = robot === followed ? FOLLOWED : '#ffffff';
    pen.lineWidth = robot === followed ? 2.5 : 1.2;
    pen.stroke();
    // The front.
    pen.beginPath();
    pen.moveTo(0.98 * radius, 0);
    pen.lineTo(0.5 * radius, 0.5 * radius);
    pen.lineTo(0.5 * radius, -0.5 * radius);
    pen.closePath();
    pen.fillStyle = front;
    pen.fill();
    pen.restore();
    const [middle, height] = place(x, y);
    if (robot === followed) {
      disc(middle, height, radius + 5);
      pen.strokeStyle = FOLLOWED;
      pen.lineWidth = 2;
      pen.stroke();
    }
    if (radius >= 9.5) {
      // Behind the front, where there is room.
      const turn = 2 * Math.PI * heading;
      const size = radius * (names[robot] > 99 ? 0.72 : 0.84);
      pen.font = `700 ${size.toFixed(1)}px ${FONT}`;
      pen.textAlign = 'center';
      pen.textBaseline = 'middle';
      pen.fillStyle = ink;
      const shift = 0.24 * radius;
      pen.fillText(names[robot], middle - shift * Math.cos(turn), height + shift * Math.sin(turn) + 0.06 * size);
    }
  }

  function drawScale(small) {
    const long = [1000, 500, 200, 100, 50, 20, 10].find((mm) => mm <= 0.35 * data.arena) || 10;
    const right = view.width - 10;
    const left = right - long * view.scale;
    const bottom = view.height - 8;
    pen.strokeStyle = INK;
    pen.lineWidth = 1.6;
    pen.lineCap = 'butt';
    pen.beginPath();
    pen.moveTo(left, bottom - 4);
    pen.lineTo(left, bottom + 4);
    pen.moveTo(left, bottom);
    pen.lineTo(right, bottom);
    pen.moveTo(right, bottom - 4);
    pen.lineTo(right, bottom + 4);
    pen.stroke();
    words(`${long} mm`, (left + right) / 2, bottom - 10, small, SOFT_INK);
  }

  function drawArena(when) {
    pen.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
    pen.clearRect(0, 0, view.width, view.height);
    put = { robots: [], sides: [], food: [] };
    const light = lightAt(when);
    const small = drawGround(light);
    drawLamp(light, small, when);
    drawScale(small);
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

  function made(name, parent, settings = {}) {
    const child = document.createElement(name);
    Object.assign(child, settings);
    parent.append(child);
    return child;
  }

  // Sets what changed, and touches nothing else: many frames change little.
  function set(node, key, value) {
    if (node[key] !== value) node[key] = value;
  }

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
      const button = made('button', made('th', row, { scope: 'row' }), { type: 'button', className: 'who' });
      const dot = made('span', button, { className: 'dot' });
      button.append(names[robot]);
      button.title = `follow robot ${names[robot]}`;
      button.setAttribute('aria-label', `Follow robot ${names[robot]}`);
      button.addEventListener('click', (event) => {
        follow(followed === robot ? -1 : robot);
        // After a click the space bar is for playing again; who uses the keyboard stays where they are.
        if (event.detail > 0) button.blur();
      });
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
      set(row, 'className', robot === followed ? 'followed' : '');
      const pressed = String(robot === followed);
      if (button.getAttribute('aria-pressed') !== pressed) button.setAttribute('aria-pressed', pressed);
      if (dot.dataset.colour !== colour) {
        dot.dataset.colour = colour;
        dot.style.background = colour;
      }
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

  const chart = element('chart');
  const chartPen = chart.getContext('2d');
  const bars = { width: 250, counts: [], left: 34, right: 8, top: 16, bottom: 34 };

  // 1, 2 or 5 times a power of ten, so that about so many parts make up the whole.
  function rounded(whole, parts) {
    const wanted = Math.max(whole / parts, 1e-3);
    const power = 10 ** Math.floor(Math.log10(wanted));
    return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= wanted - 1e-9);
  }

  const barOf = (line) => Math.max(0, Math.floor((data.times[line] - 1) / (10 * bars.width)));

  function buildChart() {
    // Short runs have shorter bars.
    bars.width = last >= 1000 ? 250 : Math.max(every, rounded(last, 12));
    bars.counts = new Array(Math.max(1, Math.ceil(last / bars.width - 1e-9))).fill(0);
    for (let line = 0; line < lines; line++) {
      bars.counts[barOf(line)] += broughtByAll[line] - (line > 0 ? broughtByAll[line - 1] : 0);
    }
    bars.most = Math.max(1, ...bars.counts);
    element('chart-title').textContent = `Food brought per ${bars.width} s`;
    const told = bars.counts.map((count, i) => `${count} in ${i * bars.width} to ${(i + 1) * bars.width} s`);
    chart.setAttribute('aria-label', `Food brought: ${told.join(', ')}`);
  }

  function fitChart() {
    bars.wide = Math.max(element('chart-room').clientWidth, 120);
    // What is left below the table, where that stands beside the arena.
    const above = element('chart-room').getBoundingClientRect().top + scrollY;
    const wide = matchMedia('(min-width: 1081px)').matches;
    bars.high = wide ? Math.round(Math.min(Math.max(innerHeight - above - 24, 150), 300)) : 190;
    chart.width = Math.round(bars.wide * view.ratio);
    chart.height = Math.round(bars.high * view.ratio);
    chart.style.height = `${bars.high}px`;
  }

  const chartX = (seconds) => {
    const whole = bars.counts.length * bars.width;
    return bars.left + (seconds / whole) * (bars.wide - bars.left - bars.right);
  };

  function drawChart(when) {
    const p = chartPen;
    const base = bars.high - bars.bottom;
    const step = Math.max(1, rounded(bars.most, 4));
    const top = Math.ceil(bars.most / step) * step;
    const chartY = (count) => base - (count / top) * (base - bars.top);
    p.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
    p.clearRect(0, 0, bars.wide, bars.high);
    p.font = `11px ${FONT}`;
    p.textBaseline = 'middle';
    p.textAlign = 'right';
    p.lineWidth = 1;
    for (let count = 0; count <= top; count += step) {
      p.strokeStyle = '#e1e2e6';
      p.beginPath();
      p.moveTo(bars.left, Math.round(chartY(count)) + 0.5);
      p.lineTo(bars.wide - bars.right, Math.round(chartY(count)) + 0.5);
      p.stroke();
      p.fillStyle = SOFT_INK;
      p.fillText(count, bars.left - 6, chartY(count));
    }
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
    p.fillStyle = SOFT_INK;
    const whole = bars.counts.length * bars.width;
    const unit = whole >= 600 ? 60 : 1;
    const tick = rounded(whole / unit, 7) * unit;
    for (let seconds = 0; seconds <= whole + 1e-9; seconds += tick) {
      // The outermost stay within the chart.
      p.textAlign = seconds > 0.97 * whole ? 'right' : 'center';
      p.fillText(Number((seconds / unit).toFixed(6)), chartX(seconds) + (p.textAlign === 'right' ? bars.right - 2 : 0), base + 11);
    }
    p.textAlign = 'center';
    p.fillText(unit === 60 ? 'minutes' : 'seconds', (bars.left + bars.wide - bars.right) / 2, base + 26);
    for (const [cycle] of data.lights.slice(1)) {
      if (cycle / 10 > whole) continue;
      const x = Math.round(chartX(cycle / 10)) + 0.5;
      p.strokeStyle = '#a87400';
      p.setLineDash([4, 3]);
      p.beginPath();
      p.moveTo(x, bars.top - 6);
      p.lineTo(x, base);
      p.stroke();
      p.setLineDash([]);
      p.textAlign = x > 0.6 * bars.wide ? 'right' : 'left';
      p.fillStyle = '#7a5400';
      p.fillText('light moves', x + (p.textAlign === 'left' ? 4 : -4), bars.top - 8);
    }
    const x = chartX(when);
    p.strokeStyle = INK;
    p.lineWidth = 1.6;
    p.beginPath();
    p.moveTo(x, bars.top - 4);
    p.lineTo(x, base);
    p.stroke();
    p.fillStyle = INK;
    p.beginPath();
    p.moveTo(x - 4, bars.top - 8);
    p.lineTo(x + 4, bars.top - 8);
    p.lineTo(x, bars.top - 2);
    p.fill();
  }

  // ---- Words around the arena.

  function buildLegend() {
    const legend = element('legend');
    const entry = (picture, text) => {
      const item = made('li', legend);
      item.innerHTML = `<svg width="18" height="18" viewBox="-9 -9 18 18" aria-hidden="true">${picture}</svg>`;
      item.append(text);
    };
    acts.filter(({ marks }) => marks).forEach(({ short, colour, marks: [front] }) => {
      entry(`<circle r="7.5" fill="${colour}"/><path d="M7 0L3.2 3.4V-3.4Z" fill="${front}"/>`, short);
    });
    const grain = `fill="${FOOD}" stroke="${FOOD_EDGE}"`;
    entry(`<circle cx="-4.8" r="3.6" ${grain}/><circle cx="2" r="6" fill="#c9ccd3"/>`, 'with food');
    if (!data.whole) return;
    entry(`<circle r="8" fill="#93b94a4d" stroke="#55741c8c"/><circle r="3" ${grain}/>`, 'food');
    entry(`<path d="M-8 4L8 -4" stroke="${ENCOUNTER}" stroke-width="2.4" stroke-linecap="round"/>`, 'heard');
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

  function say(text) {
    element('said').textContent = text;
  }

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
    const slider = element('when');
    if (Number(slider.value) !== when) slider.value = when;
    const shown = `${clock(when)} of ${clock(last)}`;
    if (slider.getAttribute('aria-valuetext') !== shown) {
      slider.setAttribute('aria-valuetext', shown);
      const box = element('clock');
      box.replaceChildren();
      made('b', box, { textContent: clock(when) });
      box.append(` of ${clock(last)}`);
    }
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

  let due = false;
  let before = 0;

  function frame(now) {
    due = false;
    if (playing) {
      // After a pause of the page itself it goes on, and does not jump.
      time += (Math.min(now - before, 100) / 1000) * speed;
      if (time >= last) {
        time = last;
        play(false);
      }
    }
    before = now;
    show();
    if (playing) ask();
  }

  function ask() {
    if (due) return;
    due = true;
    requestAnimationFrame(frame);
  }

  function play(on) {
    if (on && (lines < 2)) return;
    if (on && time >= last) time = first;
    playing = on;
    before = performance.now();
    const button = element('play');
    set(button, 'textContent', on ? 'Pause' : 'Play');
    ask();
  }

  function seek(to) {
    time = Math.min(Math.max(to, first), last);
    ask();
  }

  function stepBy(count) {
    play(false);
    const { line, share } = locate(time);
    // From between two lines, back means to the one before.
    const from = share > 0 && count < 0 ? line + 1 : line;
    seek(timeOf(Math.min(Math.max(from + count, 0), Math.max(lines - 1, 0))));
  }

  function follow(robot) {
    followed = robot;
    say(robot < 0 ? 'Following no robot.' : `Following robot ${names[robot]}.`);
    ask();
  }

  function setSpeed(index) {
    const at = Math.min(Math.max(index, 0), SPEEDS.length - 1);
    speed = SPEEDS[at];
    element('speed').selectedIndex = at;
  }

  function robotUnder(event) {
    if (lines === 0) return -1;
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const where = locate(time);
    let best = { robot: -1, distance: Math.max(1.3 * data.body * view.scale, 14) };
    for (let robot = 0; robot < robots; robot++) {
      const at = pose(robot, where);
      if (!at) continue;
      const [left, top] = place(at.x, at.y);
      const distance = Math.hypot(left - x, top - y);
      if (distance < best.distance) best = { robot, distance };
    }
    return best.robot;
  }

  function listen() {
    element('play').addEventListener('click', () => play(!playing));
    element('back').addEventListener('click', () => stepBy(-1));
    element('forth').addEventListener('click', () => stepBy(1));
    element('when').addEventListener('input', (event) => seek(Number(event.target.value)));
    element('speed').addEventListener('change', (event) => setSpeed(event.target.selectedIndex));
    canvas.addEventListener('click', (event) => {
      const robot = robotUnder(event);
      follow(robot === followed ? -1 : robot);
    });
    canvas.addEventListener('mousemove', (event) => {
      canvas.style.cursor = robotUnder(event) < 0 ? 'default' : 'pointer';
    });
    chart.style.cursor = 'pointer';
    chart.addEventListener('click', (event) => {
      const share = (event.clientX - chart.getBoundingClientRect().left - bars.left) / (bars.wide - bars.left - bars.right);
      seek(share * bars.counts.length * bars.width);
    });
    document.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const target = event.target;
      const many = event.shiftKey ? 10 : 1;
      const acts = {
        ' ': () => play(!playing),
        ArrowLeft: () => stepBy(-many),
        ArrowRight: () => stepBy(many),
        Home: () => seek(first),
        End: () => seek(last),
        '+': () => setSpeed(SPEEDS.indexOf(speed) + 1),
        '-': () => setSpeed(SPEEDS.indexOf(speed) - 1),
        Escape: () => follow(-1),
      };
      // Buttons and lists keep the keys that they need.
      if (target.tagName === 'BUTTON' && event.key === ' ') return;
      if (target.tagName === 'SELECT' && event.key !== 'Escape') return;
      const act = acts[event.key];
      if (!act) return;
      event.preventDefault();
      act();
    });
    const refit = () => {
      // A canvas of a new size is empty: it is drawn at once, so that nothing flickers.
      fit();
      fitChart();
      show();
    };
    new ResizeObserver(refit).observe(element('room'));
    addEventListener('resize', refit);
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
  function spread() {
    const slider = element('when');
    slider.min = first;
    slider.max = last;
    slider.disabled = lines < 2;
    for (const id of ['play', 'back', 'forth']) element(id).disabled = lines < 2;
    buildLights();
    buildChart();
  }

  function start() {
    SPEEDS.forEach((times) => made('option', element('speed'), { textContent: `${times}\u00d7` }));
    setSpeed(SPEEDS.indexOf(speed));
    buildLegend();
    buildTable();
    spread();
    fit();
    fitChart();
    listen();
    const wanted = new URLSearchParams(location.hash.slice(1));
    if (wanted.has('robot')) followed = names.indexOf(Number(wanted.get('robot')));
    if (wanted.has('t')) seek(Number(wanted.get('t')) || 0);
    show();
    if (data.live) look();
    else if (!wanted.has('t') && !calm.matches) play(true);
  }

  // `take` is for the script with newer data. `drawn` is for tests: it draws a time, and tells where robots and food were drawn,
  // mm and turns, taken back from the canvas, and what colour the canvas has where a robot's side should be.
  window.oneiro = {
    take,
    drawn(when) {
      play(false);
      seek(when);
      drawArena(time);
      const colours = put.sides.map(([x, y]) => {
        const pixel = pen.getImageData(Math.floor(x), Math.floor(y), 1, 1).data;
        return `#${Array.from(pixel.slice(0, 3), (part) => part.toString(16).padStart(2, '0')).join('')}`;
      });
      return { time, robots: put.robots.map((robot, i) => ({ ...robot, colour: colours[i] })), food: put.food };
    },
  };

  start();
})();
