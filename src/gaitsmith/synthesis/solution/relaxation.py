"""The default bound of torque rates, relaxed step by step where it leaves no gait; a user's own bound never is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from gaitsmith.synthesis.gaits.gait import Gait
from gaitsmith.synthesis.gaits.worst import Worst
from gaitsmith.synthesis.program.program import ImposedBound
from gaitsmith.synthesis.program.rates import is_rate
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.ipopt import Solution
from gaitsmith.synthesis.solution.rate_check import rate_margins

Array = npt.NDArray[np.float64]
_STEP = 1.6  # by which the bound grows where a program with it was not solved
_PATIENCE = 3  # rounds in which rates alone exceed it, before it moves to what they reach
_NEAR = 2.0  # times the bound, if they reach no more than that
_ROOM = 1.02
_STEPS = 3  # after so many there is no bound, until the rest holds


@dataclass(frozen=True, eq=False)
class Before:
    """Where planning stood before rates were imposed: bounds, unknowns, solution."""

    imposed: list[ImposedBound]
    x: Array
    found: Solution


@dataclass(eq=False)
class Relaxation:
    """What became of a bound that nobody gave.

    Attributes:
        trans: whose settings hold the bound in use.
        default: it as it was before, N·m/s.
        before: None until rates are imposed.
    """

    trans: Transcription
    default: float = field(init=False)
    before: Before | None = None
    _alone: int = 0
    _steps: int = 0

    def __post_init__(self) -> None:
        self.default = float(self.trans.settings.bounds.torque_rate)

    @property
    def allowed(self) -> bool:
        """Whether the bound is a default."""
        return "torque_rate" not in self.trans.settings.bounds.model_fields_set

    @property
    def relaxed(self) -> bool:
        """Whether the bound in use is another one than the default."""
        return self.trans.settings.bounds.torque_rate > self.default

    @property
    def replaced(self) -> float | None:
        """The default, N·m/s, where the bound in use is another one."""
        return self.default if self.relaxed else None

    @property
    def unbounded(self) -> bool:
        """Whether there is no bound for now."""
        return bool(np.isinf(self.trans.settings.bounds.torque_rate))

    def imposes(self, imposed: list[ImposedBound]) -> bool:
        """Whether a default is among the imposed bounds, so that a failure may be its own, and there is a way back."""
        return (
            self.allowed
            and self.before is not None
            and any(is_rate(self.trans, item.phase, item.bound) for item in reversed(imposed))
        )

    def restart(self) -> Before | None:
        """After a failure: the bound a step further, and where to go on from; None where it is a user's."""
        if not self.allowed or self.before is None:
            return None
        self._steps += 1
        self._use(_STEP * self.trans.settings.bounds.torque_rate if self._steps <= _STEPS else np.inf)
        before, self.before, self._alone = self.before, None, 0
        return before

    def accepts(self, largest: float, last: bool) -> bool:
        """Where rates alone exceed the bound: whether it moves to the ``largest`` of them; ``last``: of all rounds."""
        if self.unbounded:
            self._use(_ROOM * largest)
            return True
        self._alone += 1
        near = largest < _NEAR * self.trans.settings.bounds.torque_rate
        if not self.allowed or not (last or (near and self._alone > _PATIENCE)):
            return False
        self._use(_ROOM * largest)
        return True

    def settled(self, gait: Gait, moving: Sequence[str], count: int) -> tuple[Gait, dict[str, Worst]]:
        """A finished gait and its worst torque rates at ``count`` instants a phase.

        A relaxed bound goes with a rate that lies beyond it where the rounds did not look.
        """
        most = float(self.trans.settings.bounds.torque_rate)
        steep = rate_margins(gait, most, moving, count)
        beyond = [abs(item.value) for item in steep.values() if item.violation > 0.0 and abs(item.limit) == most]
        if self.relaxed and beyond:
            self._use(_ROOM * max(beyond))
            bounds = self.trans.settings.bounds
            return replace(gait, bounds=bounds.model_dump()), rate_margins(gait, bounds.torque_rate, moving, count)
        return gait, steep

    def _use(self, most: float) -> None:
        settings = self.trans.settings
        bounds = settings.bounds.model_copy(update={"torque_rate": most})
        bounds.model_fields_set.discard("torque_rate")
        self.trans.settings = settings.model_copy(update={"bounds": bounds})
