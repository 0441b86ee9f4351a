"""What the controller did about readings that it could not believe: found in its telemetry, told once each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsmith.documents import Frozen
from gaitsmith.estimation.readings import GOOD, WHAT
from gaitsmith.log.columns import Columns

if TYPE_CHECKING:
    from gaitsmith.simulation.faults import Fault

_MOST = 200  # kept; a sensor that comes and goes would fill the memory
_BEYOND = {"ticks": "late", "balance": "torso tilted or hips sunk too far"}
WEAK, TOLD = "does not give the torque that it is told", "told; the other joints make up for it as far as they can"
BRAKED, DAMPED = "joints braked: it cannot be done without", "joints braked"
DRIVES = "the motors' drives brake the joints, as no torque comes"
FALLING = "weak, and the robot falls"
UNNOTICED = "none: not noticed"


class Reaction(Frozen):
    """Something that went wrong, as the controller saw it.

    Attributes:
        time: s since the run began.
        component: a sensor, ``ticks``, ``balance``, or a motor.
        type: what is wrong with it, in words.
        reaction: what was done about it, in words.
    """

    time: float
    component: str
    type: str
    reaction: str


def stand_in(component: str, estimated: bool) -> str:
    """What a sensor's reading is replaced by, in words."""
    kind = component.rpartition(".")[2]
    angle = "the model's acceleration, and the sole that stands" if estimated else "the joint's rate"
    words = {
        "base_position": "dead reckoning",
        "attitude": "angular velocity",
        "base_velocity": "differences of position and attitude",
        "angle": angle,
        "rate": "differences of the joint's angle",
        "accelerometer": "gravity",
        "gyro": "the model's acceleration, kept to the attitude",
        "force": "kinematics and the step's clock",
    }
    return f"replaced by {words[kind]}"


class Reactions:
    """Observer that reads telemetry; every new fault is told as an event.

    Args:
        columns: of telemetry.
        estimated: whether the state is estimated.
        dt: s from one observation to the next.
        tell: hears of every reaction.

    Attributes:
        found: so far, at most two hundred.
        dropped: how many more there were.
    """

    def __init__(self, columns: Columns, estimated: bool, dt: float, tell: Callable[[Mapping[str, Any]], None]) -> None:
        self.found: list[Reaction] = []
        self.dropped = 0
        self._tell, self._estimated, self._dt, self._now = tell, estimated, dt, 0.0
        self._names, blank = columns.labels("reading"), np.zeros(1)
        views = [columns.find(name) for name in ("reading", "motor", "reading_changes", "reading_lost", "missed_ticks")]
        found = (blank if view is None else view for view in views)
        self._what, self._motor, self._changes, self._lost, self._missed = found
        self._motors, self._weak = columns.labels("motor"), np.zeros(len(self._motor))
        self._known, self._counted = np.zeros(len(self._names)), (0.0, -1.0, 0.0)

    def observe(self, tick: int) -> bool:
        """Look for what has changed; never ends the run."""
        self._now = tick * self._dt
        counts = (self._changes[0], self._lost[0], self._missed[0])
        if self._names and counts != self._counted:
            self._note(tuple(map(float, counts)))
        return False

    def hear(self, event: Mapping[str, Any]) -> None:
        """Nothing that is told matters here."""

    def _note(self, counts: tuple[float, ...]) -> None:
        before, self._counted = self._counted, (counts[0], counts[1], counts[2])
        for c in np.flatnonzero(self._what != self._known):
            if self._what[c] != GOOD and self._known[c] == GOOD:
                name = self._names[c]
                self.add(name, WHAT[int(self._what[c])], stand_in(name, self._estimated))
        self._known[:] = self._what
        for j in np.flatnonzero(self._motor > self._weak):
            self.add(f"{self._motors[j]}.motor", WEAK, TOLD)
        self._weak[:] = self._motor
        lost = int(counts[1])
        if counts[1] != before[1] and lost >= 0:
            name = (*self._names, *_BEYOND, *(f"{joint}.motor" for joint in self._motors))[lost]
            kind = WHAT[int(self._what[lost])] if lost < len(self._names) else _BEYOND.get(name, FALLING)
            self.add(name, kind, BRAKED if name != "balance" else DAMPED)
        elif counts[2] != before[2] and not (self.found and self.found[-1].component == "ticks"):
            self.add("ticks", "late", "the last torque held, the step's clock advanced")

    def add(self, component: str, kind: str, reaction: str) -> None:
        """Take note of something, and tell of it."""
        if len(self.found) >= _MOST:
            self.dropped += 1
            return
        found = Reaction(time=self._now, component=component, type=kind, reaction=reaction)
        self.found.append(found)
        self._tell({"reaction": found.model_dump()})


def ended_braked(found: Iterable[Reaction], fell: float) -> bool:
    """Whether the joints were braked, and it was told why, before a robot fell, s."""
    return any(entry.reaction in (BRAKED, DAMPED, DRIVES) and entry.time < fell for entry in found)


def _concerns(fault: Fault, found: Reaction) -> bool:
    """Whether a reaction can be to a fault: of the same joint or sole, if the fault is of one."""
    place, dot, _ = fault.component.partition(".")
    return found.component != "balance" and (not dot or found.component.partition(".")[0] == place)


def with_unnoticed(found: tuple[Reaction, ...], faults: tuple[Fault, ...], duration: float) -> tuple[Reaction, ...]:
    """Reactions, and the faults of the scenario that nothing was done about, by time.

    What is said of another joint or sole is not about a fault of this one.
    """
    silent = []
    for fault in faults:
        until = fault.time + fault.duration + 0.2
        about = [e for e in found if fault.time - 2e-3 <= e.time <= until and _concerns(fault, e)]
        if not about and fault.time < duration:
            silent.append(Reaction(time=fault.time, component=fault.component, type=fault.type, reaction=UNNOTICED))
    return tuple(sorted([*found, *silent], key=lambda entry: entry.time))
