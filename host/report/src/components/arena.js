// The arena's canvas: places in mm, y up, and what stands in the arena.
import { FONT, Theme, faded } from './colours.js';
import { element } from './dom.js';
import { bytes } from './facts.js';
import { SvgPen } from './svg-pen.js';

/**
 * What drawing a frame put where, for tests.
 * @typedef {{ name: number | string, x: number, y: number, heading: number }} Put
 */

/** @param {number} grey of the floor, from 0 to 1: black is a dark grey, so that paths are visible */
const shade = (grey) => Math.floor(70 + 185 * grey);

/** The least height that the arena gets, in pixels. */
const LEAST = 200;

export class Arena {
  /** @param {Theme} theme */
  constructor(theme) {
    this.theme = theme;
    this.canvas = element('arena', HTMLCanvasElement);
    this.room = element('room', HTMLElement);
    this.pen = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext('2d'));
    /** From mm to pixels, and the canvas's size in them. */
    this.view = { scale: 1, x: 0, y: 0, width: 1, height: 1, ratio: 1 };
    /** @type {{ robots: Put[], sides: [number, number][] }} */
    this.put = { robots: [], sides: [] };
    /** Colours of what is drawn on the floor. */
    this.marks = theme.colours;
    /** @type {Map<string, HTMLCanvasElement>} pictures on floors, by their cells */
    this.pictures = new Map();
  }

  get colours() {
    return this.theme.colours;
  }

  /** @param {number} x @param {number} y in mm @returns {[number, number]} */
  place(x, y) {
    return [this.view.x + x * this.view.scale, this.view.y - y * this.view.scale];
  }

  /** Height of small text, in pixels. */
  get small() {
    return Math.max(10, Math.min(13, 0.02 * this.view.width));
  }

  /**
   * Fits what lies between these places into the page.
   * @param {import('./facts.js').Bounds} bounds
   */
  fitTo({ left, right, bottom, top }) {
    const { canvas, room, view } = this;
    const [main, field, dock] = ['main', 'field', 'dock'].map((id) => element(id, HTMLElement));
    const width = Math.max(room.clientWidth, 120);
    // What the page has above and below stays in sight, on a projector of 1024 by 600 too.
    const around = main.offsetTop + field.offsetHeight - room.offsetHeight + dock.offsetHeight + 20;
    const height = Math.min((width * (top - bottom)) / (right - left), Math.max(LEAST, innerHeight - around));
    view.ratio = devicePixelRatio || 1;
    view.width = width;
    view.height = Math.round(height);
    view.scale = Math.min(view.width / (right - left), view.height / (top - bottom));
    view.x = view.width / 2 - (view.scale * (left + right)) / 2;
    view.y = view.height / 2 + (view.scale * (bottom + top)) / 2;
    canvas.width = Math.round(view.width * view.ratio);
    canvas.height = Math.round(view.height * view.ratio);
    canvas.style.height = `${view.height}px`;
  }

  /** Before what is drawn: nothing was put anywhere. */
  clear() {
    const { pen, view } = this;
    pen.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
    // A saved picture has the page's colour too.
    pen.fillStyle = this.colours.page;
    pen.fillRect(0, 0, view.width, view.height);
    this.put = { robots: [], sides: [] };
    this.marks = this.colours;
  }

  /**
   * What `draw` draws, as SVG.
   * @param {() => void} draw
   */
  svg(draw) {
    const { pen, view } = this;
    const { ratio } = view;
    const own = new SvgPen(view.width, view.height);
    this.pen = /** @type {any} */ (own);
    view.ratio = 1;
    draw();
    this.pen = pen;
    view.ratio = ratio;
    return own.text(document.title);
  }

  /** @param {number} x @param {number} y @param {number} radius in pixels */
  disc(x, y, radius) {
    this.pen.beginPath();
    this.pen.arc(x, y, radius, 0, 2 * Math.PI);
  }

  /** @param {string} style @param {number} width */
  stroke(style, width) {
    this.pen.strokeStyle = style;
    this.pen.lineWidth = width;
    this.pen.stroke();
  }

  /** @param {string | CanvasGradient} style */
  fill(style) {
    this.pen.fillStyle = style;
    this.pen.fill();
  }

  /**
   * Text with a rim of the page's colour, to be read on whatever is below it.
   * @param {string} text
   * @param {[number, number]} place in pixels
   * @param {number} size
   * @param {string} colour
   * @param {number} [weight]
   */
  words(text, [x, y], size, colour, weight = 400) {
    const { pen } = this;
    pen.font = `${weight} ${size}px ${FONT}`;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.lineJoin = 'round';
    pen.lineWidth = 3;
    pen.strokeStyle = faded(this.colours.page, 0.85);
    pen.strokeText(text, x, y);
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
  }

  /**
   * A lamp.
   * @param {number} x @param {number} y @param {number} size in pixels
   */
  sun(x, y, size) {
    const { pen, colours } = this;
    pen.lineCap = 'round';
    pen.beginPath();
    for (let ray = 0; ray < 8; ray++) {
      const turn = (ray / 8) * 2 * Math.PI;
      pen.moveTo(x + 1.35 * size * Math.cos(turn), y + 1.35 * size * Math.sin(turn));
      pen.lineTo(x + 1.8 * size * Math.cos(turn), y + 1.8 * size * Math.sin(turn));
    }
    this.stroke(colours.lamp, 2);
    this.disc(x, y, size);
    this.fill(colours.lamp);
    this.stroke(colours['lamp-edge'], 1.2);
  }

  /**
   * Light around a lamp.
   * @param {[number, number]} place in pixels @param {number} reach @param {(share: number) => number} strength
   */
  glow([x, y], reach, strength) {
    const glow = this.pen.createRadialGradient(x, y, 0, x, y, reach);
    for (let i = 0; i <= 10; i++) glow.addColorStop(i / 10, faded(this.colours.lamp, strength(i / 10)));
    return glow;
  }

  /**
   * A line that says how long a length of at most `most` mm is.
   * @param {number} most
   */
  scale(most) {
    const { pen, view, colours } = this;
    const long = [1000, 500, 200, 100, 50, 20, 10].find((mm) => mm <= most) || 10;
    const right = view.width - 10;
    const left = right - long * view.scale;
    const bottom = view.height - 8;
    pen.lineCap = 'butt';
    pen.beginPath();
    pen.moveTo(left, bottom - 4);
    pen.lineTo(left, bottom + 4);
    pen.moveTo(left, bottom);
    pen.lineTo(right, bottom);
    pen.moveTo(right, bottom - 4);
    pen.lineTo(right, bottom + 4);
    this.stroke(colours.ink, 1.6);
    this.words(`${long} mm`, [(left + right) / 2, bottom - 10], this.small, colours.soft);
  }

  /**
   * Discs that robots push and carry.
   * @param {import('./facts.js').Place[]} places @param {number} radius in mm
   */
  pucks(places, radius) {
    for (const place of places) {
      this.outline({ middle: place, radius });
      this.fill(this.colours.food);
      this.stroke(this.colours['food-edge'], 1.2);
    }
  }

  /** Where the pen stands, taken back from pixels to mm, for tests. */
  standing() {
    const { scale, x, y, ratio } = this.view;
    const back = new DOMMatrix([scale * ratio, 0, 0, -scale * ratio, x * ratio, y * ratio]).inverse();
    const here = back.multiply(this.pen.getTransform());
    return { x: here.e, y: here.f, heading: Math.atan2(here.b, here.a) / (2 * Math.PI) };
  }

  /** The robots that were drawn, with the colour that the canvas has where their sides should be, for tests. */
  drawn() {
    const colours = this.put.sides.map(([x, y]) => {
      const pixel = this.pen.getImageData(Math.floor(x), Math.floor(y), 1, 1).data;
      return `#${Array.from(pixel.slice(0, 3), (part) => part.toString(16).padStart(2, '0')).join('')}`;
    });
    return this.put.robots.map((robot, i) => ({ ...robot, colour: colours[i] }));
  }

  /** @param {import('./facts.js').Shape} shape */
  outline({ corners, middle, radius }) {
    if (corners) {
      this.pen.beginPath();
      for (const [x, y] of corners) this.pen.lineTo(...this.place(x, y));
      this.pen.closePath();
    } else if (middle) this.disc(...this.place(...middle), (radius || 0) * this.view.scale);
  }

  /**
   * A picture on the floor.
   * @param {import('./facts.js').PictureFacts} picture
   */
  picture({ left, bottom, width, height, columns, rows, greys }) {
    const name = `${columns} ${greys}`;
    let cells = this.pictures.get(name);
    if (!cells) {
      cells = document.createElement('canvas');
      [cells.width, cells.height] = [columns, rows];
      const pen = /** @type {CanvasRenderingContext2D} */ (cells.getContext('2d'));
      const pixels = pen.createImageData(columns, rows);
      new Uint8Array(bytes(greys)).forEach((grey, at) => {
        // Rows of pixels go downwards.
        const pixel = 4 * ((rows - 1 - Math.floor(at / columns)) * columns + (at % columns));
        pixels.data.set([shade(grey / 255), shade(grey / 255), shade(grey / 255), 255], pixel);
      });
      pen.putImageData(pixels, 0, 0);
      this.pictures.set(name, cells);
    }
    const { scale } = this.view;
    this.pen.imageSmoothingEnabled = false;
    this.pen.drawImage(cells, ...this.place(left, bottom + height), width * scale, height * scale);
  }

  /**
   * Floor, walls, objects and lamps.
   * @param {import('./facts.js').ArenaFacts} facts
   */
  ground({ ground, open, floor, picture, patches, objects, walls, lamps }) {
    const { pen, colours } = this;
    /** @param {number} share */
    const grey = (share) => `rgb(${Array(3).fill(shade(share)).join(' ')})`;
    if (floor !== null) this.marks = this.theme.paper;
    pen.save();
    this.outline(ground);
    this.fill(floor === null ? colours.floor : grey(floor));
    pen.clip();
    if (picture) this.picture(picture);
    for (const patch of patches) {
      this.outline(patch);
      this.fill(grey(patch.grey || 0));
    }
    pen.restore();
    if (open) {
      this.outline(ground);
      pen.setLineDash([6, 5]);
      this.stroke(colours.soft, 1.2);
      pen.setLineDash([]);
    }
    for (const object of objects) {
      this.outline(object);
      this.fill(colours.object);
      this.stroke(colours['object-edge'], 2);
    }
    pen.lineCap = 'round';
    pen.beginPath();
    for (const [from, to] of walls) {
      pen.moveTo(...this.place(...from));
      pen.lineTo(...this.place(...to));
    }
    this.stroke(colours.ink, 4);
    for (const lamp of lamps) {
      const [x, y] = this.place(...lamp);
      this.disc(x, y, 60);
      this.fill(this.glow([x, y], 60, (share) => 0.5 * (1 - share)));
      this.sun(x, y, 9);
    }
  }

  /**
   * Fits around an arena's facts: with room, and below also for the scale.
   * @param {import('./facts.js').Bounds} bounds
   */
  fitAround({ left, right, bottom, top }) {
    const room = 0.04 * Math.max(right - left, top - bottom);
    this.fitTo({ left: left - room, right: right + room, bottom: bottom - 2 * room, top: top + room });
  }
}
