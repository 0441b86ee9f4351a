"""Tune gains with Optuna: how strong a push the robot survives, in units of its mass, size and gravity.

pip install 'gaitsmith[optuna]'; python examples/10_tune_with_optuna.py      # some five minutes

`gaitsmith tune` does the same against a whole crash test, without Optuna; this is for a search or an aim of your own.
"""

import math

import numpy as np
import optuna

import gaitsmith
from gaitsmith.experiments.push_grid import momentum_unit
from gaitsmith.robots.presets import ControlParameters

RANGES = {"foothold.reach": (0.7, 1.3), "foothold.spread": (0.7, 1.3), "tracking.foot_stiffness": (0.5, 2.0)}
HELD_OUT = 1000  # seeds from here on are for the comparison


def changed(parameters: ControlParameters, factors: dict[str, float]) -> ControlParameters:
    """Parameters with some of their numbers multiplied; names that they do not have are refused."""
    numbers = parameters.model_dump()
    for name, factor in factors.items():
        group, key = name.split(".")
        value = numbers[group][key]
        numbers[group][key] = tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value
    return ControlParameters.model_validate(numbers)


def survived(robot: gaitsmith.Robot, parameters: ControlParameters, seeds: range, strength: float) -> float:
    """Share of walks that stand after a push of this strength from any side at any time."""
    controller = gaitsmith.Controller(robot, preset=parameters)
    unit = momentum_unit(robot, controller.gait.height)
    stood = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        angle, time = rng.uniform(0.0, 2.0 * math.pi), 3.0 + rng.uniform(0.0, 1.0)
        impulse = [strength * unit * math.cos(angle), strength * unit * math.sin(angle), 0.0]
        scenario = gaitsmith.Scenario(speed=(0.3, 0.0), duration=8.0, pushes=({"time": time, "impulse": impulse},))
        stood += not gaitsmith.run_episode(scenario, robot=robot, controller=controller, record=False).summary.fell
    return stood / len(seeds)


def main(trials: int = 20, runs: int = 12, held_out: int = 24, strength: float = 0.65) -> tuple[float, float]:
    robot = gaitsmith.load_robot("bhr_b2")
    default = gaitsmith.Controller(robot).parameters

    def aim(trial: optuna.Trial) -> float:
        factors = {name: trial.suggest_float(name, *limits, log=True) for name, limits in RANGES.items()}
        return survived(robot, changed(default, factors), range(runs), strength)

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(direction="maximize", sampler=optuna.samplers.TPESampler(seed=0))
    study.enqueue_trial(dict.fromkeys(RANGES, 1.0))  # the gains as they are
    study.optimize(aim, n_trials=trials)
    seeds = range(HELD_OUT, HELD_OUT + held_out)
    before, after = (survived(robot, p, seeds, strength) for p in (default, changed(default, study.best_params)))
    print("factors: " + ", ".join(f"{name} {value:.2f}" for name, value in study.best_params.items()))
    print(f"stood after {held_out} pushes not tuned on: card's gains {before:.0%}, found ones {after:.0%}")
    return before, after


if __name__ == "__main__":
    main()
