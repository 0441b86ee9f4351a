"""Steps, gaits and gains that the template's tests are about, and a pendulum to walk them on."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from tests.control.walking import parameters, robot

from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.foothold import FootholdGains, Forecast, make_foothold_gains
from gaitsmith.template.step import GaitInputs, StepState, make_gait_inputs, make_step_state
from gaitsmith.whole_body.frames import Frames, make_frames

Array = npt.NDArray[np.float64]

GRAVITY, HEIGHT = 9.81, 0.33  # m/s², m: of the pendulums here
OMEGA = math.sqrt(GRAVITY / HEIGHT)


def gains(**changes: Any) -> FootholdGains:
    """THBIP-II's foothold gains, so wide that no bound is met, for a pendulum of the tests' height."""
    chosen = parameters("thbip_ii").foothold.model_copy(
        update={"reach": 10.0, "spread": 10.0, "separation": 1e-6, **changes}
    )
    return make_foothold_gains(chosen, GRAVITY, HEIGHT, (0.0, 10.0))


def inputs(**changes: Any) -> GaitInputs:
    """THBIP-II's gait with changes."""
    return make_gait_inputs(GaitParameters(**{**robot("thbip_ii").card.gait.model_dump(), **changes}))


def a_step(gait: GaitInputs, time: float = 0.0) -> StepState:
    """A step of that gait taken for its speed, some time after it began."""
    step = make_step_state(2, 6)
    step.speed[:], step.period[:] = gait.speed, gait.period
    return at(step, time)


def at(step: StepState, time: float) -> StepState:
    """The step at another time; nothing has changed its duration."""
    step.time[0] = step.place[0] = time
    return step


def forecast() -> Forecast:
    """A pendulum of the tests' height over the stance sole."""
    return Forecast(np.array([0.0, 0.0, HEIGHT]), *(np.zeros(2) for _ in range(4)))


def some_frames(seed: int = 0) -> Frames:
    """Frames of two soles filled with random numbers."""
    rng, frames = np.random.default_rng(seed), make_frames(18, 2)
    for array in frames:
        array[...] = rng.normal(size=array.shape)
    return frames


def swing(arm: Array, velocity: Array, time: float) -> tuple[Array, Array]:
    """A linear pendulum over its pivot after some time: arm (2,), velocity (2,)."""
    c, s = math.cosh(OMEGA * time), math.sinh(OMEGA * time)
    return c * arm + s / OMEGA * velocity, OMEGA * s * arm + c * velocity
