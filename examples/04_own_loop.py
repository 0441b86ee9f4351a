"""A loop of your own: any backend, any source of commands, anybody who watches.

A robot takes the place of ``gaitsmith.Plant``: it fills ``joint_position``, ``accelerometer``, ``gyro``,
``base_quaternion`` and ``sole_force`` in ``measure``, takes torques in ``step``, has a clock ``time``, and its
controller is made with ``state="estimated"``.

python examples/04_own_loop.py
"""

from collections.abc import Iterable, Mapping
from typing import Any

import gaitsmith
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.simulation import Loop, Order


class Joystick:
    """Asked between two ticks: walk forwards, stop after three fifths of the time."""

    def __init__(self, duration: float) -> None:
        self.left = [(0.0, Order({"speed": (0.3, 0.0)}, "walk")), (0.6 * duration, Order({"speed": (0.0, 0.0)}))]

    def poll(self, time: float) -> Iterable[Order]:
        while self.left and self.left[0][0] <= time:
            yield self.left.pop(0)[1]


class Watcher:
    """Told of every tick and of every order."""

    def __init__(self, controller: gaitsmith.Controller) -> None:
        self.telemetry = controller.telemetry

    def observe(self, tick: int) -> bool:
        if tick % 500 == 0:
            forward, left, _ = self.telemetry.com_velocity
            foothold = self.telemetry.foothold[0]
            print(f"{1e-3 * tick:4.1f} s: v {forward:+.3f} {left:+.3f} m/s, next foothold {foothold:+.3f} m ahead")
        return False  # True would end the run

    def hear(self, event: Mapping[str, Any]) -> None:
        print(f"{event['time']:4.1f} s: told {event.get('command')}")


def main(duration: float = 6.0) -> gaitsmith.Controller:
    robot = gaitsmith.load_robot("bhr_b2")
    gait = robot.card.gait
    controller, plant = gaitsmith.Controller(robot), gaitsmith.Plant(robot)
    plant.reset(standing_posture(robot, gait.height, gait.width))
    controller.reset()
    loop = Loop(plant, controller, Joystick(duration), [Watcher(controller)])
    while loop.time < duration and loop.step():
        pass
    return controller


if __name__ == "__main__":
    main()
