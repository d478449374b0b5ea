#!/usr/bin/env python3
"""swarm.py TRACE.csv: prints a moving picture (SVG) of a swarm's trace, as `oneiro replay` writes it, that browsers loop.

The arena is that of experiments/gather.toml: a square of 1,500 mm with a dark patch. Needs only Python.
"""
import csv
import sys

SIDE, PATCH, RADIUS = 1500, (1000, 750, 300), 35
SECONDS = 24  # of the picture; the episode is faster than in reality
EVERY = 4  # cycles from one position to the next; browsers draw what is between

with open(sys.argv[1], newline="") as file:
    rows = list(csv.DictReader(file))[::EVERY]
robots = [("x_mm", "y_mm", "heading_turns")]
while f"robot_{len(robots)}.x" in rows[0]:
    robots.append(tuple(f"robot_{len(robots)}.{axis}" for axis in "xyz"))

style = """
.field { fill: #fff; stroke: #57606a } .patch { fill: #57606a; opacity: .35 } .body { fill: #0969da } .nose { stroke: #fff }
@media (prefers-color-scheme: dark) {
  .field { fill: #0d1117; stroke: #9198a1 } .patch { fill: #9198a1 } .body { fill: #4493f8 } .nose { stroke: #0d1117 }
}""".strip()
print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -10 {SIDE + 20} {SIDE + 20}" width="420" height="420">')
print(f"<style>{style}</style>")
print(f'<rect class="field" width="{SIDE}" height="{SIDE}" stroke-width="8"/>')
print('<circle class="patch" cx="{}" cy="{}" r="{}"/>'.format(PATCH[0], SIDE - PATCH[1], PATCH[2]))
for columns in robots:
    places, turns, before = [], [], None
    for row in rows:
        x, y, heading = (float(row[column]) for column in columns)
        # Clockwise, since y points down; the shorter way round from the heading before.
        angle = -360 * heading
        if before is not None:
            angle = before + (angle - before + 180) % 360 - 180
        before = angle
        places.append(f"{x:.0f} {SIDE - y:.0f}")
        turns.append(f"{angle:.0f}")
    timing = f'dur="{SECONDS}s" repeatCount="indefinite"'
    print(f'<g><animateTransform attributeName="transform" type="translate" {timing} values="{";".join(places)}"/>')
    print(f'<g><animateTransform attributeName="transform" type="rotate" {timing} values="{";".join(turns)}"/>')
    print(f'<circle class="body" r="{RADIUS}"/><path class="nose" d="M0 0H{RADIUS - 6}" stroke-width="9"/></g></g>')
print("</svg>")
