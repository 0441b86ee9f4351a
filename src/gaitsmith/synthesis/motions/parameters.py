"""What the paper's motions are told: the numbers of a step, a kick and a jump."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from gaitsmith.synthesis.motions.settings import LEG


@dataclass(frozen=True)
class StepParameters:
    """One step of a walk.

    Attributes:
        length: L_step, distance from one foothold to the next, m.
        period: of a step, s.
        height: H_step, ankle above its height on the ground at mid-swing, m.
        double_support: share of the period.
        heel_share: share of the double support in which the front foot turns about its heel.
        toe_share: share of it in which the rear foot turns about its toe; both are flat in between.
        toe_off: q_b, pitch of the rear foot as it leaves the ground, rad.
        swing_split: share of the swing until the foot is at its highest.
        heel_strike: q_f, pitch of the front foot as it meets the ground, rad, toe up.
        shift: duration of the weight shift before the first and after the last step, s.
        rise: of stairs, by which every step is higher, m; negative where they lead down.
        base: height of the ground on which a walk on stairs begins, m.
        turn: heading of a foothold against the one before, rad.
        slope: by which the ground rises ahead, rad.
    """

    length: float
    period: float
    height: float = 0.04
    double_support: float = 0.30
    heel_share: float = 0.30
    toe_share: float = 0.30
    toe_off: float = 0.20
    heel_strike: float = 0.15
    swing_split: float = 0.5
    shift: float = 0.6
    rise: float = 0.0
    base: float = 0.0
    turn: float = 0.0
    slope: float = 0.0

    @property
    def transfer(self) -> float:
        """Duration of double support, s."""
        return self.period * self.double_support

    @classmethod
    def sized(cls, leg: float, length: float, period: float, **given: float) -> StepParameters:
        """The same step for hips ``leg`` m high with straight legs, where ``given`` says nothing else."""
        size = leg / LEG
        return cls(length, period, **({"height": cls.height * size, "shift": cls.shift * size**0.5} | given))


@dataclass(frozen=True)
class KickParameters:
    """The kick of section 6.2; positions in a frame midway between the soles at rest, of the ankle.

    Attributes:
        ball: x and y of the ankle when it meets the ball, m.
        speed: v_max, m/s.
        reach: x_max, m.
        height: H_max of the raised foot, m.
        strike: height of the sole at the ball, m: a level toe meets a ball of radius 0.05 m below its middle.
        durations: of the six phases, s.
    """

    ball: tuple[float, float] = (0.02, 0.065)
    speed: float = 2.0
    reach: float = 0.14
    height: float = 0.06
    strike: float = 0.02
    durations: tuple[float, float, float, float, float, float] = (0.8, 0.6, 0.35, 0.3, 0.9, 0.8)


@dataclass(frozen=True)
class JumpParameters:
    """A jump with both feet.

    Attributes:
        height: of the soles above the ground, m.
        durations: of push-off and of landing, s.
        flight: share of the time that a body thrown up by the height is in the air: feet that are drawn up need less.
    """

    height: float = 0.03
    durations: tuple[float, float] = (0.8, 0.8)
    flight: float = 1.0


def record(kind: str, values: object) -> dict[str, float]:
    """Parameters as plain numbers."""
    found: dict[str, float] = {}
    for key, value in asdict(values).items():  # type: ignore[call-overload]
        if isinstance(value, tuple):
            found |= {f"{key}_{k + 1}": float(item) for k, item in enumerate(value)}
        else:
            found[key] = float(value)
    return found
