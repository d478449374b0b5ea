// Marks the section that is being read in a report's list of contents.

/** Marks it from now on. */
export function followContents() {
  const links = [...document.querySelectorAll('nav a[href^="#"]')];
  const sections = links.map((link) => document.getElementById((link.getAttribute('href') || '').slice(1)));

  function mark() {
    // The last section that begins in the upper third of the window; at the page's ends, the first and the last.
    const isEnd = innerHeight + scrollY >= document.documentElement.scrollHeight - 2;
    const begun = sections.filter((section) => section && section.getBoundingClientRect().top < innerHeight / 3);
    const last = isEnd ? sections.length - 1 : sections.indexOf(begun[begun.length - 1] || null);
    const current = scrollY > 0 ? last : 0;
    links.forEach((link, place) => {
      if (place === current) link.setAttribute('aria-current', 'true');
      else link.removeAttribute('aria-current');
    });
    const link = links[current];
    // In a narrow window the list scrolls by itself.
    if (link instanceof HTMLElement && link.parentElement) link.parentElement.scrollLeft = link.offsetLeft - 40;
  }

  addEventListener('scroll', mark, { passive: true });
  addEventListener('resize', mark);
  mark();
}
