#!/usr/bin/env python3
"""Speed in larger and larger worlds: sizes.py PROGRAM [walls|patches|robots=NUMBER]... [task=KIND] [specialise=WHEN] [against=OTHER]

Prints a million cycles of a robot per second of one thread, by the processor's time, of what more trials of random genomes take; of three runs
the shortest. Walls and patches: an e-puck among walls of 112 mm, or on discs of 100 mm radius, one in each square of 225 mm. Robots: swarms
of e-pucks that see each other and stay together, or have another task, 20 on each square metre. Against another program: the median of eight
ratios to its speed, measured in turns.
"""
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile

SIDE = 225.0
# Genomes, cycles of an episode, and how many trials fewer and more; of robots as many genomes as make 16 times 1,024 of them.
ALONE = (512, 500, 4, 24)
TOGETHER = (16 * 1024, 100, 2, 4)
USUAL = [
    *(f"walls={number}" for number in (20, 64, 100, 1000)),
    *(f"patches={number}" for number in (12, 64, 1000, 4096)),
    *(f"robots={number}" for number in (16, 64, 128, 129, 256, 1024)),
]


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


def alone(what, number):
    """An experiment with so many walls or patches."""
    side = math.ceil(math.sqrt(number)) * SIDE
    one = {"walls": wall, "patches": patch}[what]
    lines = ",\n".join(one(*place) for place in places(number))
    return f"""robot.preset = "epuck"
[arena]
width_mm = {side}
height_mm = {side}
{what} = [
{lines}
]
"""


def together(robots, task):
    """An experiment with so many robots."""
    side = 1000.0 * math.sqrt(robots / 20)
    return f"""[robot]
preset = "epuck"
count = {robots}
sensors = [
    {{ name = "left", kind = "proximity", heading_turns = 0.05, range_mm = 100.0 }},
    {{ name = "right", kind = "proximity", heading_turns = -0.05, range_mm = 100.0 }},
    {{ name = "sees", kind = "sight", range_mm = 200.0 }},
]
[arena]
width_mm = {side}
height_mm = {side}
[task]
kind = "{task}"
"""


def processor_seconds(program, experiment, genomes, trials, specialise):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    how = ["--random", str(genomes), "--trials", str(trials), "--threads", "1", "--specialise", specialise, "--summary"]
    subprocess.run([program, "evaluate", experiment, *how], check=True, capture_output=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    program, *arguments = sys.argv[1:]
    given = dict(argument.split("=") for argument in arguments)
    task, specialise = given.pop("task", "stay-together"), given.pop("specialise", "never")
    other = given.pop("against", None)
    sizes = [argument.split("=") for argument in (arguments if given else USUAL)]
    with tempfile.TemporaryDirectory() as folder:
        for what, number in (size for size in sizes if size[0] in ("walls", "patches", "robots")):
            robots = int(number) if what == "robots" else 1
            genomes, cycles, few, many = TOGETHER if what == "robots" else ALONE
            genomes //= robots
            experiment = os.path.join(folder, f"{what}-{number}.toml")
            with open(experiment, "w") as file:
                file.write(f"cycles = {cycles}\n" + (together(robots, task) if what == "robots" else alone(what, int(number))))

            def seconds(program, many, times):
                measured = [[processor_seconds(program, experiment, genomes, trials, specialise) for trials in (few, many)] for _ in range(times)]
                short, long = (min(column) for column in zip(*measured))
                return long - short

            if other:
                turns = [[program, other], [other, program]] * 4
                taken = [{each: seconds(each, 5 * many, 1) for each in turn} for turn in turns]
                ratio = statistics.median(own[other] / own[program] for own in taken)
                print(number, what + ":", round(ratio, 3), "of the speed of", other, flush=True)
            else:
                steps = genomes * robots * cycles * (many - few)
                print(number, what + ":", round(steps / seconds(program, many, 3) / 1e6, 2), "million cycles/s", flush=True)


main()
