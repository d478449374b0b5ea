#!/usr/bin/env python3
"""pictures.py: draws the pictures that experiments name, line-follower/track.png and map-maze/map.png, next to itself. Needs only Python."""
import math
import pathlib
import struct
import zlib

FOLDER = pathlib.Path(__file__).parent


def write(name, rows):
    """Writes 8-bit greys as a PNG; rows come from the top."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 9)
    (FOLDER / name).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b""))


def drawn(width, height, side, grey):
    """A picture of pixels of a side in mm, by the grey at their middles; y goes up."""
    return [[grey((x + 0.5) * side, (height - y - 0.5) * side) for x in range(width)] for y in range(height)]


def distance(x, y, a, b):
    """From a place to a line between two others."""
    along, away = (b[0] - a[0], b[1] - a[1]), (x - a[0], y - a[1])
    part = max(0.0, min(1.0, (along[0] * away[0] + along[1] * away[1]) / (along[0] ** 2 + along[1] ** 2)))
    return math.hypot(away[0] - part * along[0], away[1] - part * along[1])


def track(x, y):
    """A black line of 28 mm, whose edges fade over 12 mm."""
    nearest = min(distance(x, y, a, b) for a, b in zip(CURVE, CURVE[1:] + CURVE[:1]))
    return round(255 * max(0.0, min(1.0, (nearest - 14) / 12)))


CURVE = []
for step in range(120):
    t = 2 * math.pi * step / 120
    far = 1 + 0.17 * math.sin(3 * t) + 0.09 * math.cos(5 * t)
    CURVE.append((600 + 430 * far * math.cos(t), 400 + 270 * far * math.sin(t)))


def rooms(x, y):
    """Free, occupied and unknown pixels as ROS's map server writes them."""
    if not (30 < x < 1570 and 30 < y < 1170):
        return 205
    inner = (50 < x < 1550 and 50 < y < 1150)
    walls = [((550, 50), (550, 800)), ((1050, 400), (1050, 1150)), ((1050, 400), (1250, 310))]
    solid = any(distance(x, y, a, b) < 11 for a, b in walls) or math.hypot(x - 280, y - 860) < 90
    return 254 if inner and not solid else 0


write("line-follower/track.png", drawn(300, 200, 4, track))
write("map-maze/map.png", drawn(160, 120, 10, rooms))
