#!/usr/bin/env python3
"""khepera.py PORT: a Khepera to try the program with, behind a TCP port of this computer. It answers as a real one does on a serial port.

It drives towards a wall 300 mm ahead, which its front sensors notice from 40 mm on. Needs only Python.
"""
import socket
import sys
import time

server = socket.create_server(("127.0.0.1", int(sys.argv[1])))
server.settimeout(600)  # It ends if nobody connects for ten minutes.
speeds, travel, moved_at = [0, 0], [0.0, 0.0], time.monotonic()


def answer(command):
    """The answer to a command: a letter, and numbers."""
    global speeds, travel, moved_at
    now = time.monotonic()
    # Speeds are in pulses of 1/12 mm every 10 ms.
    travel = [way + 100 * speed * (now - moved_at) for way, speed in zip(travel, speeds)]
    moved_at = now
    letter, *rest = command.split(",")
    if letter == "T":
        return "t," + ",".join(rest)
    try:
        numbers = [int(number) for number in rest]
    except ValueError:
        return "z,Protocol error"
    ahead = 300 - sum(travel) / 24
    front = round(min(1023, max(0, 25 * (40 - ahead))))
    values = {
        "B": ["5.01", "5.00"],
        "E": speeds,
        "H": [round(way) for way in travel],
        "I": [900],
        "K": [0, 1, 0, 0, 1, 0],
        "N": [0, 0, front, front, 0, 0, 0, 0],
        "O": [500] * 8,
    }
    if letter == "D":
        speeds = [max(-127, min(127, number)) for number in numbers]
    elif letter == "G":
        travel = [float(number) for number in numbers]
    elif letter not in [*values, *"ACFJLPW"]:
        return "Command not found"
    return ",".join([letter.lower(), *map(str, values.get(letter, []))])


while True:
    link, _ = server.accept()
    with link:
        pending = b""
        while received := link.recv(1024):
            *commands, pending = (pending + received).replace(b"\r", b"\n").split(b"\n")
            for command in filter(None, commands):
                link.sendall((answer(command.decode(errors="replace")) + "\r\n").encode())
