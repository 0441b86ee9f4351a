"""Change the controller's numbers without touching the card, and compare.

python examples/06_own_gains.py
"""

import gaitsmith
from gaitsmith.robots.presets import ControlParameters


def main(duration: float = 8.0) -> dict[str, float]:
    robot = gaitsmith.load_robot("bhr_b2")
    default = gaitsmith.Controller(robot).parameters
    numbers = default.model_dump()
    numbers["foothold"] |= {"deadbeat": 0.0, "velocity_gain": (0.20, 0.20)}
    presets = {"default": default, "fixed k_v of 0.2 s": ControlParameters.model_validate(numbers), "paper": "paper"}
    errors = {}
    for name, parameters in presets.items():
        scenario = gaitsmith.Scenario(speed=(0.4, 0.0), duration=duration)
        controller = gaitsmith.Controller(robot, preset=parameters)
        summary = gaitsmith.run_episode(scenario, robot=robot, controller=controller, record=False).summary
        errors[name] = summary.stages[-1].vx_error
        print(f"{name:20s} {1000.0 * errors[name]:+7.1f} mm/s{', fell' if summary.fell else ''}")
    return errors


if __name__ == "__main__":
    main()
