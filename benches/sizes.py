#!/usr/bin/env python3
"""Speed in larger and larger worlds: sizes.py PROGRAM walls|robots [NUMBER]...

Prints a million cycles of a robot per second of one thread, by the processor's time, of what more trials of random genomes take: the best
of three. Walls: an e-puck in mazes, where a wall of 112 mm stands in each square of 225 mm. Robots: swarms of e-pucks that see each other and
stay together, 20 on each square metre.
"""
import math
import os
import resource
import subprocess
import sys
import tempfile

SIDE = 225.0
# What is measured: genomes, cycles of an episode, and how many trials fewer and more.
SIZES = {"walls": (512, 500, 4, 24), "robots": (16, 100, 2, 4)}
NUMBERS = {"walls": ["20", "64", "100", "1000"], "robots": ["16", "64", "128", "129", "256", "1024"]}


def walls(count):
    """An experiment with so many walls."""
    columns = math.ceil(math.sqrt(count))
    lines = []
    for wall in range(count):
        column, row = divmod(wall, columns)
        x, y = (SIDE * (place + 0.5) for place in (column, row))
        across, along = (SIDE / 4, 0.0) if (column + row) % 2 else (0.0, SIDE / 4)
        lines.append(f"{{ from_mm = [{x - across}, {y - along}], to_mm = [{x + across}, {y + along}] }},")
    side = columns * SIDE
    return f"""robot.preset = "epuck"
[arena]
width_mm = {side}
height_mm = {side}
walls = [
{chr(10).join(lines)}
]
"""


def robots(count):
    """An experiment with so many robots."""
    side = 1000.0 * math.sqrt(count / 20)
    return f"""[robot]
preset = "epuck"
count = {count}
sensors = [
    {{ name = "left", kind = "proximity", heading_turns = 0.05, range_mm = 100.0 }},
    {{ name = "right", kind = "proximity", heading_turns = -0.05, range_mm = 100.0 }},
    {{ name = "sees", kind = "sight", range_mm = 200.0 }},
]
[arena]
width_mm = {side}
height_mm = {side}
[task]
kind = "stay-together"
"""


def processor_seconds(program, experiment, genomes, trials):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    how = ["--random", str(genomes), "--trials", str(trials), "--threads", "1", "--specialise", "never", "--summary"]
    subprocess.run([program, "evaluate", experiment, *how], check=True, capture_output=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    program, of, *numbers = sys.argv[1:]
    genomes, cycles, few, many = SIZES[of]
    experiment_of = {"walls": walls, "robots": robots}[of]
    with tempfile.TemporaryDirectory() as folder:
        for count in map(int, numbers or NUMBERS[of]):
            experiment = os.path.join(folder, f"{count}.toml")
            with open(experiment, "w") as file:
                file.write(f"cycles = {cycles}\n" + experiment_of(count))
            runs = max(1024 // count, 1) if of == "robots" else 1
            took = [
                processor_seconds(program, experiment, genomes * runs, many) - processor_seconds(program, experiment, genomes * runs, few)
                for _ in range(3)
            ]
            steps = genomes * runs * cycles * (many - few) * (count if of == "robots" else 1)
            print(count, f"{of}:", round(steps / min(took) / 1e6, 2), "million cycles/s", flush=True)


main()
