#!/usr/bin/env python3
"""Speed of an e-puck in mazes of more and more walls: mazes.py PROGRAM [WALLS]...

Prints a million cycles per second of one thread, by the processor's time, of what 20 more trials of 512 random genomes take. A wall of
112 mm stands in each square of 225 mm. The best of three is taken.
"""
import math
import os
import resource
import subprocess
import sys
import tempfile

SIDE = 225.0
GENOMES, CYCLES, FEW, MANY = 512, 500, 4, 24


def maze(walls):
    """An experiment with so many walls."""
    columns = math.ceil(math.sqrt(walls))
    lines = []
    for wall in range(walls):
        column, row = divmod(wall, columns)
        x, y = (SIDE * (place + 0.5) for place in (column, row))
        across, along = (SIDE / 4, 0.0) if (column + row) % 2 else (0.0, SIDE / 4)
        lines.append(f"{{ from_mm = [{x - across}, {y - along}], to_mm = [{x + across}, {y + along}] }},")
    side = columns * SIDE
    return f"""cycles = {CYCLES}
robot.preset = "epuck"
[arena]
width_mm = {side}
height_mm = {side}
walls = [
{chr(10).join(lines)}
]
"""


def processor_seconds(program, experiment, trials):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    how = ["--random", str(GENOMES), "--trials", str(trials), "--threads", "1", "--specialise", "never", "--summary"]
    subprocess.run([program, "evaluate", experiment, *how], check=True, capture_output=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    program, *numbers = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        for walls in map(int, numbers or ["20", "64", "100", "1000"]):
            experiment = os.path.join(folder, f"{walls}.toml")
            with open(experiment, "w") as file:
                file.write(maze(walls))
            took = [processor_seconds(program, experiment, MANY) - processor_seconds(program, experiment, FEW) for _ in range(3)]
            print(walls, "walls:", round(GENOMES * CYCLES * (MANY - FEW) / min(took) / 1e6, 1), "million cycles/s")


main()
