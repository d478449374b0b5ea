"""thymio.py PORT: thymiodirect reads all variables of a Thymio II, drives it, and stops it. Prints a line of JSON for each, and
waits for a line before it goes on."""
import asyncio
import json
import os
import sys
import time

from thymiodirect import Thymio

asyncio.set_event_loop(asyncio.new_event_loop())
robot = Thymio(use_tcp=True, host="127.0.0.1", tcp_port=int(sys.argv[1]))
robot.connect()
node = robot.first_node()
# It asks for all variables every 0.1 s.
time.sleep(0.5)


def say(what):
    print(json.dumps(what), flush=True)
    sys.stdin.readline()


names = robot.variables(node)
events, (functions, _) = robot.events(node), robot.native_functions(node)
say({"node": node, "values": {name: robot[node][name] for name in names}, "events": events, "functions": functions})
for left, right in [(120, -80 & 0xFFFF), (0, 0)]:
    robot[node]["motor.left.target"] = left
    robot[node]["motor.right.target"] = right
    # A message that is answered after those.
    time.sleep(0.5)
    say([robot[node]["motor.left.target"], robot[node]["motor.right.target"]])
# Its threads don't end.
os._exit(0)
