#!/usr/bin/env python3
"""Speed of an e-puck among more and more walls, or on a floor of more and more patches: mazes.py PROGRAM [walls|patches=NUMBER]...

Prints a million cycles per second of one thread, by the processor's time, of what 20 more trials of 512 random genomes take. A wall of
112 mm stands in each square of 225 mm, or a disc of 100 mm radius lies there. The best of three is taken.
"""
import math
import os
import resource
import subprocess
import sys
import tempfile

SIDE = 225.0
GENOMES, CYCLES, FEW, MANY = 512, 500, 4, 24


def places(number):
    columns = math.ceil(math.sqrt(number))
    for place in range(number):
        column, row = divmod(place, columns)
        yield (column + row) % 2, *(SIDE * (at + 0.5) for at in (column, row))


def wall(is_odd, x, y):
    across, along = (SIDE / 4, 0.0) if is_odd else (0.0, SIDE / 4)
    return f"{{ from_mm = [{x - across}, {y - along}], to_mm = [{x + across}, {y + along}] }}"


def patch(is_odd, x, y):
    return f"{{ x_mm = {x}, y_mm = {y}, radius_mm = 100.0, grey = {0.25 if is_odd else 0.75} }}"


def arena(what, number):
    """An experiment with so many walls or patches."""
    side = math.ceil(math.sqrt(number)) * SIDE
    one = {"walls": wall, "patches": patch}[what]
    lines = ",\n".join(one(*place) for place in places(number))
    return f"""cycles = {CYCLES}
robot.preset = "epuck"
[arena]
width_mm = {side}
height_mm = {side}
{what} = [
{lines}
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
        for argument in numbers or ["walls=20", "walls=64", "walls=100", "walls=1000", "patches=12", "patches=64", "patches=1000", "patches=4096"]:
            what, number = argument.split("=")
            experiment = os.path.join(folder, f"{what}-{number}.toml")
            with open(experiment, "w") as file:
                file.write(arena(what, int(number)))
            few, many = (min(processor_seconds(program, experiment, trials) for _ in range(3)) for trials in (FEW, MANY))
            print(number, what + ":", round(GENOMES * CYCLES * (MANY - FEW) / (many - few) / 1e6, 1), "million cycles/s")


main()
