// Colours of the page's scheme, light or dark: page.css has them as variables, and canvases paint with them.
import { element } from './dom.js';

export const FONT = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";

const NAMES = /** @type {const} */ (['ink', 'soft', 'rule', 'page', 'floor', 'object', 'object-edge', 'faint', 'link', 'lamp', 'lamp-edge',
  'lamp-text', 'message', 'sensor', 'food', 'food-edge', 'food-text', 'food-faint', 'nest', 'nest-text', 'rim']);

/**
 * Colours as `#rrggbb`, by the names of page.css.
 * @typedef {Record<typeof NAMES[number], string>} Colours
 */

/** @param {Element} where @returns {Colours} */
function read(where) {
  const style = getComputedStyle(where);
  return /** @type {Colours} */ (Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()])));
}

/** Colours that follow the scheme. */
export class Theme {
  /** @param {() => void} changed called after the scheme changed */
  constructor(changed) {
    this.colours = read(document.documentElement);
    /** Colours on a floor that is light in both schemes. */
    this.paper = read(element('arena', HTMLElement));
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.colours = read(document.documentElement);
      changed();
    });
  }
}

/**
 * Red, green and blue from 0 to 1.
 * @param {string} colour as `#rrggbb`
 */
const channels = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255);

/**
 * Black or white, whichever is the easier to read on a colour.
 * @param {string} colour as `#rrggbb`
 */
export function inkOn(colour) {
  const [red, green, blue] = channels(colour).map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
  // Where both have a contrast of 4.58.
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 ? '#000000' : '#ffffff';
}

/**
 * A colour that shows what is below it.
 * @param {string} colour as `#rrggbb`
 * @param {number} alpha
 */
export const faded = (colour, alpha) => `${colour}${Math.round(255 * alpha).toString(16).padStart(2, '0')}`;
