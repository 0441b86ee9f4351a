"""What a user may ask for: kinds of motions, ranges, and the request that names one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.parameters import JumpParameters, KickParameters, StepParameters
from gaitsmith.synthesis.motions.settings import LEG, Settings

Kind = Literal["cyclic", "start", "stop", "walk", "kick", "stairs", "turn", "jump"]
KINDS: tuple[Kind, ...] = ("cyclic", "start", "stop", "walk", "kick", "stairs", "turn", "jump")
ON_LINES: tuple[Kind, ...] = ("cyclic", "start", "stop", "walk")  # of soles that are lines
RANGES = {"--speed": (0.01, 2.0), "--step-length": (0.005, 1.0), "--period": (0.1, 10.0)}  # m/s, m, s
KICK_SPEEDS = (0.1, 20.0)  # m/s, of the ankle
MOST_CYCLES = 250  # a gait file of 50 MB holds about 300
KICK_FRICTION = 0.45  # leaves the plant's friction of 0.5 and more some room
_AGREE = 1e-6  # m
_SHORTEST, _LONGER = 0.12, 0.2  # m, and m for every m/s: steps of the paper's two gaits, of a leg of LEG


def stride(
    speed: float | None, length: float | None, period: float | None, leg: float = LEG, usual: float | None = None
) -> tuple[float, float]:
    """Step length (m) and period (s) from any two of speed, step length and period, for hips ``leg`` m high.

    With one, the other follows the line through the paper's two gaits (0.15 m in 1.0 s, 0.20 m in 0.5 s), on which
    the length is 0.12 m + 0.2 s times the speed; with none, its static gait. Other legs: in proportion. A robot with a
    ``usual`` period, s, has that where neither length nor period is given.

    Raises:
        BadInput: a value out of range, given or derived, or three that do not agree.
    """
    given = {"--speed": speed, "--step-length": length, "--period": period}
    for flag, value in given.items():
        low, high = RANGES[flag]
        if value is not None and not low <= value <= high:
            raise BadInput(flag, value, f"{low:g} to {high:g}")
    if usual is not None and length is None and period is None:
        period, length = usual, 0.15 * (leg / LEG) ** 0.5 * usual if speed is None else None
    length, period = _stride(speed, length, period, leg / LEG)
    flags = " and ".join(f"{flag} {value:g}" for flag, value in given.items() if value is not None)
    for flag, value in {"--speed": length / period, "--step-length": length, "--period": period}.items():
        low, high = RANGES[flag]
        if given[flag] is None and not low <= value <= high:
            raise BadInput(flags, f"{flag} {value:g} from them", f"{low:g} to {high:g} for {flag}")
    return length, period


def _stride(speed: float | None, length: float | None, period: float | None, size: float) -> tuple[float, float]:
    """Length and period from what is given, before they are looked at."""
    shortest, longer = _SHORTEST * size, _LONGER * size**0.5
    if speed is not None and length is not None and period is not None and abs(length - speed * period) > _AGREE:
        valid = f"{speed * period:.6g} m, speed times period"
        raise BadInput("--step-length", length, valid, "give any two of --speed, --step-length, --period")
    if length is None and speed is not None:
        length = speed * period if period is not None else shortest + longer * speed
    elif length is None and period is not None:
        if period <= 1.25 * longer:
            valid = f"more than {1.25 * longer:.4g} s when given alone"
            raise BadInput("--period", period, valid, "give --speed or --step-length too")
        length = shortest / (1.0 - longer / period)
    if length is None:
        return 0.15 * size, size**0.5
    if period is None and speed is None:
        if length <= shortest + 0.005 * size:
            valid = f"more than {shortest + 0.005 * size:.4g} m when given alone"
            raise BadInput("--step-length", length, valid, "give --speed or --period too")
        speed = (length - shortest) / longer
    return length, length / speed if period is None and speed is not None else float(period or 0.0)


@dataclass(frozen=True)
class Request:
    """A motion by name.

    Attributes:
        kind: which.
        step: of the walk that it belongs to.
        kick: of the kick.
        jump: of the jump.
        cycles: steps of the cyclic gait in a walk.
        settings: order, bounds, tolerances.
        faster: whether shorter steps at the same speed are tried where there is no gait: a robot with narrow soles or
            heavy legs cannot walk as slowly, for its size, as the paper's.
        free_times: whether phase times and foot pitches of the step are free, for the least J.

    Raises:
        BadInput: more cycles than a gait file holds, or fewer than none.
    """

    kind: Kind
    step: StepParameters = field(default_factory=lambda: StepParameters(0.15, 1.0))
    kick: KickParameters = field(default_factory=KickParameters)
    jump: JumpParameters = field(default_factory=JumpParameters)
    cycles: int = 10
    settings: Settings = field(default_factory=Settings)
    faster: bool = False
    free_times: bool = False

    def __post_init__(self) -> None:
        if not 0 <= self.cycles <= MOST_CYCLES:
            raise BadInput("--cycles", self.cycles, f"0 to {MOST_CYCLES}")
