// Tables and figures that are wider or higher than their boxes.

/** Lets the keyboard reach the boxes that scroll now. */
function reach() {
  for (const box of document.querySelectorAll('.scroll, figure')) {
    const isWide = box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight;
    if (isWide && getComputedStyle(box).overflowX !== 'visible') box.setAttribute('tabindex', '0');
    else box.removeAttribute('tabindex');
  }
}

/** Lets the keyboard reach them from now on. */
export function reachScrolled() {
  addEventListener('resize', reach);
  reach();
}
