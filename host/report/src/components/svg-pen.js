// A pen that writes SVG: what drawings of the arena need of a canvas's pen, which draws pixels.

/** What `save` keeps. */
const KEPT = /** @type {const} */ (['matrix', 'region', 'fillStyle', 'strokeStyle', 'lineWidth', 'lineCap', 'lineJoin', 'dash', 'font',
  'textAlign', 'globalAlpha']);
/** @type {Record<string, string>} */
const ANCHORS = { center: 'middle', right: 'end', end: 'end' };

/** @param {number} value */
const short = (value) => String(Math.round(100 * value) / 100);
/** @param {string} text */
const escaped = (text) => text.replace(/[&<>"]/g, (mark) => `&#${mark.charCodeAt(0)};`);

class Gradient {
  /** @param {string} circle */
  constructor(circle) {
    this.circle = circle;
    /** @type {[number, string][]} */
    this.stops = [];
  }

  /** @param {number} share @param {string} colour */
  addColorStop(share, colour) {
    this.stops.push([share, colour]);
  }
}

export class SvgPen {
  /** @param {number} width @param {number} height in pixels */
  constructor(width, height) {
    this.size = [width, height].map(short);
    /** @type {string[]} */
    this.elements = [];
    this.definitions = 0;
    this.path = '';
    this.matrix = new DOMMatrix();
    this.region = '';
    /** @type {string | Gradient} */
    this.fillStyle = '#000000';
    this.strokeStyle = '#000000';
    this.lineWidth = 1;
    this.lineCap = 'butt';
    this.lineJoin = 'miter';
    /** @type {number[]} */
    this.dash = [];
    this.font = '10px sans-serif';
    this.textAlign = 'start';
    this.globalAlpha = 1;
    /** @type {object[]} */
    this.saved = [];
    // A canvas's pen has two forms for all colours: `#rrggbb` and `rgba(r, g, b, a)`.
    this.colours = /** @type {CanvasRenderingContext2D} */ (document.createElement('canvas').getContext('2d'));
  }

  save() {
    this.saved.push(Object.fromEntries(KEPT.map((key) => [key, this[key]])));
  }

  restore() {
    Object.assign(this, this.saved.pop());
  }

  /** @param {number[]} matrix */
  setTransform(...matrix) {
    this.matrix = new DOMMatrix(matrix);
  }

  getTransform() {
    return this.matrix;
  }

  /** @param {number} x @param {number} y */
  translate(x, y) {
    this.matrix = this.matrix.translate(x, y);
  }

  /** @param {number} angle */
  rotate(angle) {
    this.matrix = this.matrix.rotate((angle * 180) / Math.PI);
  }

  /** @param {number} x @param {number} y */
  at(x, y) {
    const place = this.matrix.transformPoint({ x, y });
    return `${short(place.x)} ${short(place.y)}`;
  }

  beginPath() {
    this.path = '';
  }

  closePath() {
    this.path += 'Z';
  }

  /** @param {number} x @param {number} y */
  moveTo(x, y) {
    this.path += `M${this.at(x, y)}`;
  }

  /** @param {number} x @param {number} y */
  lineTo(x, y) {
    this.path += `${this.path ? 'L' : 'M'}${this.at(x, y)}`;
  }

  /** @param {number} x @param {number} y @param {number} radius @param {number} from @param {number} to */
  arc(x, y, radius, from, to) {
    /** @param {number} angle */
    const place = (angle) => /** @type {[number, number]} */ ([x + radius * Math.cos(angle), y + radius * Math.sin(angle)]);
    this.lineTo(...place(from));
    // An arc that ends where it begins would be none.
    for (const share of [0.5, 1]) {
      this.path += `A${short(radius)} ${short(radius)} 0 0 1 ${this.at(...place(from + share * (to - from)))}`;
    }
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  fillRect(x, y, width, height) {
    this.path = `M${this.at(x, y)}L${this.at(x + width, y)}L${this.at(x + width, y + height)}L${this.at(x, y + height)}Z`;
    this.fill();
  }

  /** @param {HTMLCanvasElement} picture @param {number} x @param {number} y @param {number} width @param {number} height */
  drawImage(picture, x, y, width, height) {
    const [left, top] = this.at(x, y).split(' ');
    const place = `x="${left}" y="${top}" width="${short(width)}" height="${short(height)}"`;
    const how = 'preserveAspectRatio="none" style="image-rendering: pixelated"';
    this.elements.push(`<g${this.region}><image ${place} ${how} href="${picture.toDataURL()}"/></g>`);
  }

  /** @param {number[]} dash */
  setLineDash(dash) {
    this.dash = dash;
  }

  /** @param {number} x @param {number} y @param {number} inner @param {number} right @param {number} top @param {number} radius */
  createRadialGradient(x, y, inner, right, top, radius) {
    const [left, height] = this.at(right, top).split(' ');
    return new Gradient(`cx="${left}" cy="${height}" r="${short(radius)}" fx="${short(x)}" fy="${short(y)}" fr="${short(inner)}"`);
  }

  clip() {
    const name = this.name();
    this.elements.push(`<clipPath id="${name}"><path d="${this.path}"/></clipPath>`);
    this.region = ` clip-path="url(#${name})"`;
  }

  name() {
    this.definitions += 1;
    return `d${this.definitions}`;
  }

  /**
   * A colour without its transparency, and that.
   * @param {string} style @returns {[string, number]}
   */
  parts(style) {
    this.colours.fillStyle = style;
    const colour = String(this.colours.fillStyle);
    const numbers = colour.match(/[\d.]+/g) || [];
    return colour.startsWith('#') ? [colour, 1] : [`rgb(${numbers.slice(0, 3).join(',')})`, Number(numbers[3])];
  }

  /** @param {'fill' | 'stroke'} kind @param {string} style */
  paint(kind, style) {
    const [colour, alpha] = this.parts(style);
    const opacity = alpha * this.globalAlpha;
    return ` ${kind}="${colour}"${opacity < 1 ? ` ${kind}-opacity="${short(opacity)}"` : ''}`;
  }

  fill() {
    const { fillStyle, region, path } = this;
    let paint = '';
    if (fillStyle instanceof Gradient) {
      const name = this.name();
      const stops = fillStyle.stops.map(([share, colour]) => {
        const [solid, alpha] = this.parts(colour);
        return `<stop offset="${share}" stop-color="${solid}" stop-opacity="${short(alpha * this.globalAlpha)}"/>`;
      });
      const circle = `gradientUnits="userSpaceOnUse" ${fillStyle.circle}`;
      this.elements.push(`<radialGradient id="${name}" ${circle}>${stops.join('')}</radialGradient>`);
      paint = ` fill="url(#${name})"`;
    } else paint = this.paint('fill', fillStyle);
    this.elements.push(`<path d="${path}"${paint}${region}/>`);
  }

  get stroked() {
    const { lineWidth, lineCap, lineJoin, dash } = this;
    const dashed = dash.length > 0 ? ` stroke-dasharray="${dash.join(' ')}"` : '';
    const line = ` stroke-width="${short(lineWidth)}" stroke-linecap="${lineCap}" stroke-linejoin="${lineJoin}"`;
    return this.paint('stroke', this.strokeStyle) + line + dashed;
  }

  stroke() {
    this.elements.push(`<path d="${this.path}" fill="none"${this.stroked}${this.region}/>`);
  }

  /** @param {string} text @param {number} x @param {number} y @param {string} paint */
  words(text, x, y, paint) {
    const [, weight, size, family] = this.font.match(/^(?:(\d+) )?([\d.]+)px (.*)$/) || ['', '400', '10', 'sans-serif'];
    const [left, top] = this.at(x, y).split(' ');
    const font = `font-family="${escaped(family)}" font-size="${size}" font-weight="${weight || 400}"`;
    const anchor = ANCHORS[this.textAlign] || 'start';
    const place = `x="${left}" y="${top}" text-anchor="${anchor}" dominant-baseline="central"`;
    this.elements.push(`<text ${place} ${font}${paint}>${escaped(text)}</text>`);
  }

  /** @param {string} text @param {number} x @param {number} y */
  fillText(text, x, y) {
    if (typeof this.fillStyle === 'string') this.words(text, x, y, this.paint('fill', this.fillStyle));
  }

  /** @param {string} text @param {number} x @param {number} y */
  strokeText(text, x, y) {
    this.words(text, x, y, ` fill="none"${this.stroked}`);
  }

  /** @param {string} title */
  text(title) {
    const [width, height] = this.size;
    const room = document.createElement('div');
    const head = `<svg width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"><title>${escaped(title)}</title>`;
    room.innerHTML = [head, ...this.elements, '</svg>'].join('\n');
    // With the namespace that a file needs.
    return new XMLSerializer().serializeToString(/** @type {Node} */ (room.firstChild));
  }
}
