// A controller's diagram: a network with its activations, or a state machine or behaviour tree with what acts. It is drawn once for each
// controller; frames change what is lit.
import { inkOn } from './colours.js';
import { element, set, setAttribute } from './dom.js';

/** The diagram's width, the radius of nodes, and the size of a box of a state, in its own units. */
const WIDE = 440;
const RADIUS = 7.5;
const BOX = { wide: 122, high: 26 };

/** @type {Record<string, (x: number) => number>} */
const FUNCTIONS = {
  logistic: (x) => 1 / (1 + Math.exp(-x)),
  tanh: Math.tanh,
  relu: (x) => Math.min(Math.max(x, 0), 1000),
  linear: (x) => Math.min(Math.max(x, -1000), 1000),
  step: (x) => (x > 0 ? 1 : 0),
};

/**
 * Appends an element of SVG.
 * @param {Element} parent
 * @param {string} name
 * @param {Record<string, string | number>} attributes
 * @param {string} [text]
 */
function drawn(parent, name, attributes, text = '') {
  const child = document.createElementNS(parent.namespaceURI, name);
  Object.entries(attributes).forEach(([key, value]) => child.setAttribute(key, String(value)));
  child.textContent = text;
  parent.append(child);
  return child;
}

/** @param {string} name */
const cut = (name) => (name.length > 17 ? `${name.slice(0, 16)}\u2026` : name);

/** @param {number} value */
const decimal = (value) => (value + 0).toFixed(3);

/**
 * What is computed now.
 * @typedef {object} Now
 * @property {(reading: number) => number} reading
 * @property {string} act what acts
 * @property {string[]} taken the states before and after a transition that has just been taken
 * @property {string} colour the robot's
 */

/**
 * What can be pointed at, in words.
 * @typedef {Map<Element, (now: Now | null) => string>} Told
 */

class NetworkDiagram {
  /**
   * @param {SVGElement} svg
   * @param {import('./facts.js').NetworkFacts} facts
   * @param {import('./facts.js').Reading[]} readings
   * @param {Told} told
   */
  constructor(svg, { nodes, lines }, readings, told) {
    this.nodes = nodes;
    /** The lines that lead to each node without a memory. */
    this.sums = nodes.map((_, to) => lines.filter((line) => line.to === to && !line.back));
    const last = nodes[nodes.length - 1].column;
    const columns = Array.from({ length: last + 1 }, (_, column) => nodes.filter((node) => node.column === column));
    const most = Math.max(...columns.map((column) => column.length));
    const step = Math.min(Math.max(320 / most, 12.5), 18);
    this.high = most * step + 6;
    // Lines back to outputs have room before the names.
    const room = lines.some((line) => line.back && nodes[line.to].column === last) ? 16 : 0;
    const [left, right] = [116, WIDE - 50 - room];
    const places = nodes.map((node) => {
      const column = columns[node.column];
      const wide = last > 0 ? (node.column * (right - left)) / last : 0;
      return { x: left + wide, y: this.high / 2 + (column.indexOf(node) - (column.length - 1) / 2) * step };
    });
    const radius = Math.min(RADIUS, 0.42 * step);
    const largest = Math.max(...lines.map(({ weights }) => Math.abs(weights[weights.length - 1])), 1e-9);
    this.lines = lines.map(({ from, to, back, weights, learns }) => {
      const weight = weights[weights.length - 1];
      const [a, b] = [places[from], places[to]];
      // Back lines leave and arrive at the right side, the farther the wider.
      const bow = Math.min(16 + 0.45 * Math.abs(a.y - b.y), 70);
      const lift = from === to ? 9 : 0;
      const way = back
        ? `M${a.x} ${a.y}C${a.x + bow} ${a.y - lift} ${b.x + bow} ${b.y + lift} ${b.x} ${b.y}`
        : `M${a.x} ${a.y}L${b.x} ${b.y}`;
      /** @param {number} strength of a synapse that learns; 1 of others */
      const wide = (strength) => (0.3 + (4.7 * Math.abs(weight) * strength) / largest).toFixed(2);
      const path = drawn(svg, 'path', { d: way, class: weight < 0 ? 'line minus' : 'line plus', 'stroke-width': wide(1) });
      const gates = weights.length > 1 ? ['input gate ', 'forget gate ', 'output gate ', 'candidate '] : [''];
      const values = weights.map((value, index) => gates[index] + decimal(value)).join(', ');
      told.set(path, (now) => {
        const learnt = learns ? ` by ${learns.rule}, rate ${decimal(learns.rate)}` : '';
        const strength = learns && now ? `, times strength ${decimal(now.reading(learns.strength))}` : '';
        return `${nodes[from].name}${back ? ' (cycle before)' : ''} to ${nodes[to].name}: ${values}${learnt}${strength}`;
      });
      return { path, learns, wide };
    });
    this.discs = nodes.map((node, index) => {
      const { x, y } = places[index];
      const group = drawn(svg, 'g', { class: 'node' });
      drawn(group, 'circle', { cx: x, cy: y, r: radius, class: 'ground' });
      const disc = drawn(group, 'circle', { cx: x, cy: y, r: radius });
      drawn(group, 'circle', { cx: x, cy: y, r: radius, class: 'edge' });
      const name = node.wheel || (node.column === 0 ? node.name : '');
      if (name) {
        const aside = node.column === 0 ? -radius - 4 : radius + 4 + room;
        drawn(group, 'text', { x: x + aside, y: y + 3.6, 'text-anchor': aside < 0 ? 'end' : 'start' }, cut(name));
      }
      told.set(group, (now) => (now ? `${node.name}: ${decimal(this.values(now)[index])}` : node.name));
      // Its own lines stand out.
      const ends = this.lines.filter((_, line) => lines[line].from === index || lines[line].to === index);
      group.addEventListener('pointerenter', () => ends.forEach(({ path }) => path.classList.add('near')));
      group.addEventListener('pointerleave', () => ends.forEach(({ path }) => path.classList.remove('near')));
      return disc;
    });
    /** The value at which a disc is full. */
    this.full = nodes.map((node) => (node.reading === null || node.function ? 1 : readings[node.reading].to));
    const counts = columns.map((column) => column.length);
    counts[0] -= 1;
    const inner = counts.slice(1, -1).reduce((sum, count) => sum + count, 0);
    this.words = `Network of ${counts[0]} inputs, ${inner} hidden units and ${counts[counts.length - 1]} outputs`;
    this.note = 'Blue is positive and drives wheels forwards, amber negative. Point at a line or disc for its weight or value now.';
  }

  /**
   * What each node computes. Between readings and what is remembered, it is computed here.
   * @param {Now} now
   */
  values({ reading }) {
    /** @type {number[]} */
    const values = [];
    this.nodes.forEach((node, index) => {
      const sum = node.reading === null
        ? this.sums[index].reduce((sum, { from, weights }) => sum + values[from] * weights[weights.length - 1], node.shift)
        : reading(node.reading) + node.shift;
      values.push(node.function ? FUNCTIONS[node.function](node.slope * sum) : sum);
    });
    return values;
  }

  /** @param {Now | null} now */
  show(now) {
    const values = now ? this.values(now) : [];
    this.discs.forEach((disc, index) => {
      const { zero } = this.nodes[index];
      const share = now ? (values[index] - zero) / (this.full[index] - zero) : 0;
      setAttribute(disc, 'class', share < 0 ? 'minus' : 'plus');
      setAttribute(disc, 'fill-opacity', Math.min(Math.abs(share), 1).toFixed(2));
    });
    for (const { path, learns, wide } of this.lines) {
      if (learns) setAttribute(path, 'stroke-width', wide(now ? now.reading(learns.strength) : 1));
    }
  }
}

/**
 * A box with a name.
 * @param {SVGElement} svg
 * @param {{ x: number, y: number }} middle
 * @param {string} name
 * @param {number} [rx]
 */
function box(svg, { x, y }, name, rx = 5) {
  const group = drawn(svg, 'g', { class: 'box' });
  drawn(group, 'rect', { x: x - BOX.wide / 2, y: y - BOX.high / 2, width: BOX.wide, height: BOX.high, rx });
  drawn(group, 'text', { x, y: y + 4, 'text-anchor': 'middle' }, name);
  return group;
}

/**
 * Lights a state's box in the robot's colour.
 * @param {Element} group
 * @param {string} colour empty: not at all
 */
function light(group, colour) {
  const [rect, text] = /** @type {SVGElement[]} */ ([...group.children]);
  if (rect.dataset.look === colour) return;
  rect.dataset.look = colour;
  rect.style.fill = colour;
  text.style.fill = colour && inkOn(colour);
}

/** @typedef {{ x: number, y: number }} Point */

/**
 * Where the way from a box's middle leaves the box.
 * @param {Point} middle @param {Point} to
 */
function edgeOf({ x, y }, to) {
  const [dx, dy] = [to.x - x, to.y - y];
  const share = Math.min(BOX.wide / 2 / Math.max(Math.abs(dx), 1e-9), BOX.high / 2 / Math.max(Math.abs(dy), 1e-9));
  return { x: x + dx * share, y: y + dy * share };
}

/**
 * An arrow between two boxes, bent to its right, with lines of text nearer to where it begins.
 * @param {SVGElement} svg @param {Point} a @param {Point} b @param {string[]} texts
 */
function arrowOf(svg, a, b, texts) {
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  const bend = 36 / length;
  const bent = { x: (a.x + b.x) / 2 - bend * (b.y - a.y), y: (a.y + b.y) / 2 + bend * (b.x - a.x) };
  const [from, to] = [edgeOf(a, bent), edgeOf(b, bent)];
  const group = drawn(svg, 'g', { class: 'arrow' });
  drawn(group, 'path', { d: `M${from.x} ${from.y}Q${bent.x} ${bent.y} ${to.x} ${to.y}` });
  const turn = (Math.atan2(to.y - bent.y, to.x - bent.x) * 180) / Math.PI;
  drawn(group, 'path', { class: 'head', d: 'M0 0L-9 4.5V-4.5Z', transform: `translate(${to.x} ${to.y}) rotate(${turn})` });
  const [x, y] = /** @type {const} */ (['x', 'y']).map((axis) => 0.46 * from[axis] + 0.44 * bent[axis] + 0.1 * to[axis]);
  texts.forEach((text, line) => {
    drawn(group, 'text', { x, y: y + 3.5 + 12 * (line - (texts.length - 1) / 2), 'text-anchor': 'middle' }, text);
  });
  return group;
}

/** Where one to four states are, as shares of the width, and the diagram's height. */
const STATES = [
  { high: 50, at: [[0.5, 25]] },
  { high: 120, at: [[0.15, 60], [0.85, 60]] },
  { high: 260, at: [[0.15, 56], [0.85, 56], [0.5, 230]] },
  { high: 300, at: [[0.15, 56], [0.85, 56], [0.85, 244], [0.15, 244]] },
];

class MachineDiagram {
  /**
   * @param {SVGElement} svg
   * @param {import('./facts.js').MachineFacts} facts
   * @param {Told} told
   */
  constructor(svg, { states, arrows }, told) {
    const { high, at } = STATES[states.length - 1];
    const places = at.map(([x, y]) => ({ x: x * WIDE, y }));
    this.high = high;
    this.names = states.map(([name]) => name);
    this.arrows = places.flatMap((_, from) => places.flatMap((_, to) => {
      // Transitions between the same states share an arrow.
      const own = arrows.filter((arrow) => arrow[0] === from && arrow[1] === to);
      if (own.length === 0) return [];
      const group = arrowOf(svg, places[from], places[to], own.map((arrow) => arrow[2]));
      told.set(group, () => `${this.names[from]} to ${this.names[to]}: ${own.map((arrow) => arrow[3]).join('; or ')}`);
      return [{ group, ends: `${this.names[from]}>${this.names[to]}` }];
    }));
    this.boxes = states.map(([name, words], state) => {
      const group = box(svg, places[state], name);
      told.set(group, () => words);
      return group;
    });
    this.words = `State machine of ${states.length} states`;
    this.note = 'The state that acts is filled. The arrow of a transition that is taken is marked for a moment.';
  }

  /** @param {Now | null} now */
  show(now) {
    this.boxes.forEach((group, state) => light(group, now && now.act === this.names[state] ? now.colour : ''));
    const taken = now ? now.taken.join('>') : '';
    this.arrows.forEach(({ group, ends }) => setAttribute(group, 'class', ends === taken ? 'arrow taken' : 'arrow'));
  }
}

class TreeDiagram {
  /**
   * @param {SVGElement} svg
   * @param {import('./facts.js').TreeFacts} facts
   * @param {Told} told
   */
  constructor(svg, { states, conditions }, told) {
    this.high = 70 * states.length;
    this.names = states.map(([name]) => name);
    const root = { x: 30, y: this.high / 2 };
    const places = states.map((_, branch) => ({ x: 130, y: 70 * branch + 35 }));
    /** @param {Point} from @param {Point} to */
    const edge = (from, to) => drawn(svg, 'path', { class: 'edge', d: `M${from.x} ${from.y}L${to.x} ${to.y}` });
    /** @param {Point} at @param {string} text @param {string} words */
    const node = ({ x, y }, text, words) => {
      const group = drawn(svg, 'g', { class: 'box' });
      drawn(group, 'rect', { x: x - 13, y: y - 13, width: 26, height: 26, rx: 5 });
      drawn(group, 'text', { x, y: y + 4, 'text-anchor': 'middle' }, text);
      told.set(group, () => words);
    };
    this.branches = states.map(([name, words], branch) => {
      const { x, y } = places[branch];
      const [above, below] = [-16, 16].map((down) => ({ x: x + 150, y: y + down }));
      edge(places[branch], above);
      const ways = [edge(root, places[branch]), edge(places[branch], below)];
      node(places[branch], '?', 'Selector: unless the condition holds, the behaviour acts');
      told.set(box(svg, above, conditions[branch][0], 13), () => `Condition, holds ${conditions[branch][1]}`);
      const leaf = box(svg, below, name);
      told.set(leaf, () => words);
      return { ways, leaf };
    });
    node(root, '\u2192*', 'Sequence with memory: begins with the branch that acted last, and goes on to the next while conditions hold');
    this.words = `Behaviour tree of ${states.length} branches`;
    this.note = 'The behaviour that acts is filled. The tree goes on to the next branch when a condition holds.';
  }

  /** @param {Now | null} now */
  show(now) {
    this.branches.forEach(({ ways, leaf }, branch) => {
      const acts = now !== null && now.act === this.names[branch];
      light(leaf, acts ? now.colour : '');
      ways.forEach((way) => setAttribute(way, 'class', acts ? 'edge taken' : 'edge'));
    });
  }
}

/** The controllers of a page's robots, of which one is shown. */
export class Controllers {
  /** @param {import('./facts.js').EpisodeFacts} data */
  constructor({ diagrams, diagram, readings }) {
    this.facts = diagrams;
    this.each = diagram;
    this.readings = readings;
    this.svg = element('diagram', SVGElement);
    /** The one that is drawn. */
    this.number = -1;
    /** @type {NetworkDiagram | MachineDiagram | TreeDiagram | null} */
    this.diagram = null;
    /** @type {Told} */
    this.told = new Map();
    /** @type {Element | null} */
    this.under = null;
    element('controller', HTMLElement).hidden = diagrams.length === 0;
    this.svg.addEventListener('pointerover', ({ target }) => {
      const way = target instanceof Element ? [target, target.parentElement] : [];
      this.under = way.find((own) => own && this.told.has(own)) || null;
      this.tell();
    });
    this.svg.addEventListener('pointerleave', () => {
      this.under = null;
      this.tell();
    });
  }

  /** @param {number} number */
  draw(number) {
    this.number = number;
    this.told.clear();
    this.under = null;
    this.svg.replaceChildren();
    const facts = this.facts[number];
    if (facts.kind === 'network') this.diagram = new NetworkDiagram(this.svg, facts, this.readings, this.told);
    else if (facts.kind === 'machine') this.diagram = new MachineDiagram(this.svg, facts, this.told);
    else this.diagram = new TreeDiagram(this.svg, facts, this.told);
    this.svg.setAttribute('viewBox', `0 0 ${WIDE} ${this.diagram.high}`);
    this.svg.setAttribute('aria-label', this.diagram.words);
  }

  /**
   * Shows what a robot computes.
   * @param {number} robot
   * @param {string} title
   * @param {Now | null} now null: nothing
   */
  show(robot, title, now) {
    if (this.facts.length === 0) return;
    if (this.each[robot] !== this.number) this.draw(this.each[robot]);
    /** @type {Now | null} */
    this.now = now;
    this.diagram?.show(now);
    set(element('diagram-title', HTMLElement), 'textContent', title);
    this.tell();
  }

  /** Says what the pointer is on. */
  tell() {
    const told = this.under && this.told.get(this.under);
    set(element('diagram-told', HTMLElement), 'textContent', told ? told(this.now || null) : this.diagram?.note || '');
  }
}
