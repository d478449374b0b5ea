"""epuck.py PORT: unifr-api-epuck reads the sensors of an e-puck2 over Wi-Fi, drives it, and stops it. Prints a line of JSON for
each, and waits for a line before it goes on."""
import json
import sys
import types

# It imports these for pictures, without declaring them.
for name, contents in {
    "cv2": ["MORPH_RECT"],
    "torch": [],
    "unifr_api_epuck.epuck.models.helper": ["non_max_suppression", "plot_detection"],
    "unifr_api_epuck.epuck.models.yolo": ["attempt_load"],
}.items():
    sys.modules[name] = types.ModuleType(name)
    for content in contents:
        setattr(sys.modules[name], content, None)

from unifr_api_epuck.epuck.epuck_wifi import WifiEpuck


class Epuck(WifiEpuck):
    # The package sets it to 1000 where it begins.
    TCP_PORT = property(lambda _: int(sys.argv[1]), lambda _, port: None)


# It prints for people.
out, sys.stdout = sys.stdout, sys.stderr
robot = Epuck("127.0.0.1")


def say(what):
    # Sensors are a cycle old, and a command is heard in the next one.
    for _ in range(5):
        assert robot.go_on()
    print(json.dumps(what()), file=out, flush=True)
    sys.stdin.readline()


say(lambda: {
    "proximity": robot.get_prox(),
    "distance": [robot.get_tof()],
    "ground": robot.get_ground(),
    "rotation": robot.get_gyro_axes(),
    "acceleration": robot.get_accelerometer_axes(),
    "sound": robot.get_microphones(),
    "temperature": [robot.get_temperature()],
    "floats": [robot.get_acceleration(), robot.get_orientation(), robot.get_inclination()],
    "remote": robot.get_tv_remote(),
    "battery": robot.get_battery_level(),
})
# 800 steps/s are 7.536 to it.
robot.set_speed(2, -1)
say(robot.get_motors_steps)
robot.set_speed(0, 0)
say(robot.get_motors_steps)
