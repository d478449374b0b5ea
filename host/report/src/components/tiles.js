// The map of an archive: a tile for each cell. Those of elites are chosen by the pointer and by the arrow keys.
import { element, setAttribute } from './dom.js';

/**
 * Where arrow keys lead.
 * @type {Record<string, [number, number]>}
 */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Tiles {
  /**
   * @param {import('./facts.js').Place[]} centres of elites
   * @param {object} page
   * @param {(elite: number) => void} page.choose
   * @param {(tile: { elite: number, cell: number } | null) => void} page.hover -1: no elite
   * @param {(elite: number) => string} page.told an elite in words
   */
  constructor(centres, { choose, hover, told }) {
    this.centres = centres;
    this.choose = choose;
    this.chosen = -1;
    this.map = element('map', SVGElement);
    /** @type {SVGElement[]} */
    this.tiles = [...this.map.querySelectorAll('[data-elite]')].map((tile) => /** @type {SVGElement} */ (tile));
    this.tiles.forEach((tile, elite) => tile.setAttribute('aria-label', told(elite)));
    /** @param {Event} event */
    const under = ({ target }) => {
      const { elite, cell } = target instanceof SVGElement ? target.dataset : /** @type {DOMStringMap} */ ({});
      return cell === undefined ? null : { elite: elite === undefined ? -1 : Number(elite), cell: Number(cell) };
    };
    this.map.addEventListener('pointerover', (event) => hover(under(event)));
    this.map.addEventListener('pointerleave', () => hover(null));
    this.map.addEventListener('click', (event) => {
      const tile = under(event);
      if (tile && tile.elite >= 0) choose(tile.elite);
    });
    this.map.addEventListener('keydown', (event) => this.press(event));
  }

  /** @param {number} elite */
  show(elite) {
    if (this.chosen >= 0) this.tiles[this.chosen].setAttribute('aria-selected', 'false');
    this.chosen = elite;
    const tile = this.tiles[elite];
    tile.setAttribute('aria-selected', 'true');
    // What is painted last is above its neighbours.
    element('chosen-tile', SVGPathElement).setAttribute('d', tile.getAttribute('d') || '');
    setAttribute(this.map, 'aria-activedescendant', tile.id);
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const arrow = ARROWS[event.key];
    if (!arrow || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const [x, y] = this.centres[this.chosen];
    let best = { elite: -1, distance: Infinity };
    this.centres.forEach(([right, down], elite) => {
      const [ahead, aside] = [(right - x) * arrow[0] + (down - y) * arrow[1], (right - x) * arrow[1] + (down - y) * arrow[0]];
      // Rather straight on than near.
      const distance = ahead + 3 * Math.abs(aside);
      if (ahead > 0.01 && distance < best.distance) best = { elite, distance };
    });
    if (best.elite >= 0) this.choose(best.elite);
  }
}
