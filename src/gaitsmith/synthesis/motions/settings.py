"""Settings of the planner besides the motion: bounds, weights, the order of the splines, limits of the solver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from gaitsmith.documents import Name
from gaitsmith.robots.parameters import Fraction, Parameters, Positive

if TYPE_CHECKING:
    from gaitsmith.synthesis.motions.biped import Biped

LEG = 0.39  # m: of hips this high with straight legs the lengths are that are given as defaults; others in proportion
_LENGTHS = ("zmp_margin", "squat", "foot_gap", "clearance")
_NARROW = 0.45  # of half a sole's width, the largest default margin of the ZMP; the feet may use half of their gap
_RATE = 1.73  # default torque rate in the robot's units of torque and time; 600 N·m/s of legs of LEG and 18 kg
_FASTER, _TRANSFER = np.log2(3.0), 0.30  # s
_CLEAR = 0.5  # of the ankle's lift
_YAW = 0.2  # of a sole's length and width, the default lever of its yaw moment
Array = npt.NDArray[np.float64]
Angle = Annotated[float, Field(gt=0.0, le=1.5)]
Length = Annotated[float, Field(ge=0.0, le=1.0)]
Share = Annotated[float, Field(gt=0.0, le=1.0)]
Weight = Annotated[float, Field(ge=0.0, le=1e3)]


class Bounds(Parameters):
    """Bounds that hold in every phase, besides the joint limits of the card.

    Attributes:
        friction: Coulomb coefficient.
        yaw_friction: largest moment about the vertical per newton of normal force, m.
        zmp_margin: distance that the ZMP keeps from the edge of the support sole, m; lengthwise it is 0 while both
            feet carry load, because a foot that turns about its edge has its ZMP there.
        normal_force: smallest normal force on the support sole in single support, as a share of the weight.
        squat: Δz of eq. (7), m.
        torso_pitch: largest lean forward or back, rad.
        torso_roll: largest lean to a side, rad.
        torso_yaw: largest turn against the support foot, rad.
        foot_pitch: largest pitch of the swing foot, rad.
        foot_tilt: largest roll and yaw of the swing foot, rad.
        foot_gap: smallest lateral distance between the soles' edges, m.
        clearance: height that the swing sole reaches by the middle of its swing, m; it rises and falls smoothly.
        torque: share of the card's torque limits that may be used.
        velocity: share of the card's velocity limits that may be used.
        torque_rate: largest change of a joint torque with time, N·m/s.
    """

    friction: Annotated[float, Field(gt=0.0, le=5.0)] = 0.6
    yaw_friction: Share = 0.05
    zmp_margin: Length = 0.02
    normal_force: Fraction = 0.3
    squat: Length = 0.02
    torso_pitch: Angle = 0.20
    torso_roll: Angle = 0.15
    torso_yaw: Angle = 0.15
    foot_pitch: Angle = 0.46
    foot_tilt: Angle = 0.02
    foot_gap: Length = 0.02
    clearance: Length = 0.005
    torque: Share = 1.0
    velocity: Share = 1.0
    torque_rate: Annotated[float, Field(gt=0.0, le=1e6)] = 600.0


class Settings(Parameters):
    """Transcription and solution of a motion.

    Attributes:
        order: degree of the joint splines: 4 as in the paper, or 5 (quintic).
        bounds: what every phase must respect.
        wrench_weight: of uᵀu in eq. (16) relative to τᵀτ; u in N and N·m.
        effort_weights: of τ² of joints by name in eq. (16); 1 of the others.
        rate_weight: of τ̇ᵀτ̇ beside eq. (16), times the square of the robot's unit of time.
        acceleration_weight: of q̈ᵀq̈ beside eq. (16), times the square of the robot's units of torque and time squared.
        single_nodes: collocation points in a section of single support, ends included.
        double_nodes: the same in double support.
        refinements: how often points may be added where a bound is violated between the points.
        dense: points a phase on which every bound is checked; every second one is one of the 200 of ``verify``.
        tolerance: of the solver, on scaled rows.
        max_iterations: of all solves of a motion together.
    """

    order: Literal[4, 5] = 5
    bounds: Bounds = Bounds()
    wrench_weight: Positive = 0.003
    effort_weights: dict[Name, Annotated[float, Field(ge=1e-3, le=1e3)]] = Field(default_factory=dict)
    rate_weight: Weight = 2e-4
    acceleration_weight: Weight = 1e-5
    single_nodes: Annotated[int, Field(ge=3, le=20)] = 5
    double_nodes: Annotated[int, Field(ge=3, le=20)] = 4
    refinements: Annotated[int, Field(ge=0, le=30)] = 12
    dense: Annotated[int, Field(ge=50, le=5000)] = 399
    tolerance: Annotated[float, Field(gt=0.0, le=1e-3)] = 1e-7
    max_iterations: Annotated[int, Field(ge=1, le=100_000)] = 1000

    def weights(self, names: Sequence[str]) -> Array:
        """(len(names),) weights of τ² of joints."""
        return np.array([self.effort_weights.get(name, 1.0) for name in names])

    def sized(self, biped: Biped, transfer: float | None = None, lift: float | None = None) -> Settings:
        """The same with the lengths that were not given in the robot's size, and the weight of u that goes with it.

        Torques change fast where the load changes feet fast. With ``transfer``, the duration of double support, their
        largest rate goes through 200 and 600 N·m/s at those of the paper's two gaits, 0.30 and 0.15 s for legs of LEG;
        slower ones have the former, other motions the latter. With ``lift``, how high a walk raises the ankle, m, the
        sole keeps clear of the ground by half of that by default: one that skims it lands early, at another pitch.
        """
        size, given = biped.height / LEG, set(self.bounds.model_fields_set)
        lengths = {name: size * getattr(self.bounds, name) for name in _LENGTHS if name not in given}
        if lift is not None and "clearance" in lengths:
            lengths["clearance"] = max(lengths["clearance"], _CLEAR * lift)
        if "torque_rate" not in given:
            faster = 1.0 if transfer is None else max(_TRANSFER * size**0.5 / transfer, 1.0) ** _FASTER / 3.0
            lengths["torque_rate"] = faster * _RATE * biped.effort / biped.fall_time
        if "yaw_friction" not in given:
            sizes = [leg.sole.heel + leg.sole.toe + 2.0 * leg.sole.half_width for leg in biped.robot.legs]
            lengths["yaw_friction"] = _YAW * min(sizes)
        halves = [leg.sole.half_width for leg in biped.robot.legs]
        narrow = _NARROW * biped.narrowest
        for name, most in (("zmp_margin", narrow), ("foot_gap", 0.5 * (biped.width - sum(halves)))):
            if name in lengths:
                lengths[name] = min(lengths[name], max(most, 0.0))
        bounds = self.bounds.model_copy(update=lengths)
        if "torque_rate" not in given:
            bounds.model_fields_set.discard("torque_rate")  # a default may be relaxed
        found = {"bounds": bounds}
        weight = {} if "wrench_weight" in self.model_fields_set else {"wrench_weight": size**2 * self.wrench_weight}
        return self.model_copy(update=found | weight)
