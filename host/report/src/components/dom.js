// Elements of the page.

/**
 * The element with an ID. It must be there and of this kind.
 * @template {Element} T
 * @param {string} id
 * @param {new () => T} kind
 * @returns {T}
 */
export function element(id, kind) {
  const found = document.getElementById(id);
  if (found instanceof kind) return found;
  throw new Error(`no ${kind.name} ${id}`);
}

/**
 * Appends a new element.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} name
 * @param {HTMLElement} parent
 * @param {Partial<HTMLElementTagNameMap[K]>} [settings]
 */
export function made(name, parent, settings = {}) {
  const child = document.createElement(name);
  Object.assign(child, settings);
  parent.append(child);
  return child;
}

/**
 * Sets what changed, and touches nothing else: many frames change little.
 * @template {HTMLElement} T
 * @template {keyof T} K
 * @param {T} node
 * @param {K} key
 * @param {T[K]} value
 */
export function set(node, key, value) {
  if (node[key] !== value) node[key] = value;
}

/**
 * Sets an attribute if it changed.
 * @param {Element} node
 * @param {string} name
 * @param {string} value
 */
export function setAttribute(node, name, value) {
  if (node.getAttribute(name) !== value) node.setAttribute(name, value);
}

/**
 * Adds a line to the legend: a picture in SVG, 18 by 18 about its middle, and what it means.
 * @param {string} picture
 * @param {string} text
 */
export function legendEntry(picture, text) {
  const item = made('li', element('legend', HTMLUListElement));
  item.innerHTML = `<svg width="18" height="18" viewBox="-9 -9 18 18" aria-hidden="true">${picture}</svg>`;
  item.append(text);
}

/**
 * Tells those who listen to the page.
 * @param {string} text
 */
export function say(text) {
  element('said', HTMLElement).textContent = text;
}

/** Whether the reader asks for little motion. */
export const isCalm = () => matchMedia('(prefers-reduced-motion: reduce)').matches;
