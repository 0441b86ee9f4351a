"""The loop by hand: whatever fills the measurement and takes the torques may stand in for the plant.

A robot would fill ``joint_position``, ``accelerometer``, ``gyro``, ``base_quaternion`` and ``sole_force``, and make
its controller with ``state="estimated"``.

python examples/04_own_loop.py
"""

import gaitsmith
from gaitsmith.kinematics.posture import standing_posture


def main(duration: float = 6.0) -> gaitsmith.Controller:
    robot = gaitsmith.load_robot("bhr_b2")
    gait = robot.card.gait
    controller, plant = gaitsmith.Controller(robot), gaitsmith.Plant(robot)
    plant.reset(standing_posture(robot, gait.height, gait.width))
    controller.reset()
    controller.walk()
    next_report = 0.0
    while plant.time < duration:
        controller.command(speed=(0.3 if plant.time < 0.6 * duration else 0.0, 0.0))
        plant.measure(controller.measurement)
        torque = controller.tick()
        plant.step(torque)
        telemetry = controller.telemetry
        if plant.time >= next_report:
            forward, left, _ = telemetry.com_velocity
            foothold = telemetry.foothold[0]
            print(f"{plant.time:4.1f} s: v {forward:+.3f} {left:+.3f} m/s, next foothold {foothold:+.3f} m ahead")
            next_report += 0.5
    return controller


if __name__ == "__main__":
    main()
