"""A library planned: every point from a neighbour nearer to the middle, on as many processes as there are."""

from __future__ import annotations

import io
import json
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.library.folder import START, Folder, Record, digest, end_keys
from gaitsmith.library.spec import Index, Spec, checked_spec, key_of
from gaitsmith.robots import load_robot
from gaitsmith.synthesis.files.gait_file import gait_document, gait_of
from gaitsmith.synthesis.program.program import ImposedBound
from gaitsmith.synthesis.proof.verify import verify
from gaitsmith.synthesis.requests.nearby import plan_nearby
from gaitsmith.synthesis.solution.ipopt import Solution
from gaitsmith.synthesis.solution.plan import Planner, PlanResult
from gaitsmith.work.workers import Workers, workers

Done = tuple[Record, bytes, bytes]
"""A record, the gait file's content, and what a neighbour starts from."""


@dataclass(frozen=True)
class Built:
    """How building ended.

    Attributes:
        records: by key, start and stop among them.
        base: key of the gait that start and stop belong to; empty if none could be planned.
        resumed: points found in the folder.
        seconds: spent.
        interrupted: whether Ctrl-C left some out.
    """

    records: dict[str, Record]
    base: str
    resumed: int
    seconds: float
    interrupted: bool


@dataclass(frozen=True, eq=False)
class _Made:
    """What a worker keeps from task to task."""

    spec: Spec
    planner: Planner
    motions: dict[Index, Any]


@cache
def _made(spec: str) -> _Made:
    found = checked_spec(json.loads(spec), "spec")
    planner = Planner(load_robot(found.robot))
    return _Made(found, planner, found.motions(planner.biped))


def plan_point(spec: str, point: Index, origin: str, warm: bytes) -> Done:
    """Plan one point, from a neighbour's result if there is one, else, or if that fails, from nothing."""
    made = _made(spec)
    if reason := made.spec.no_gait(point):
        return Record(status="failed", reason=reason), b"", b""
    (_, motion), settings = made.motions[point], made.spec.settings
    found, near = plan_nearby(made.planner, motion, settings, thawed(warm) if warm else None)
    return _finished(made, found, origin if near else "")


def plan_end(spec: str, point: Index, which: str, gait: bytes, warm: bytes) -> Done:
    """Plan the motion from rest to a point's gait, or back, from that gait's file and what it left."""
    made = _made(spec)
    (step, _), settings = made.motions[point], made.spec.settings
    biped, cycle = made.planner.biped, gait_of(json.loads(gait))
    q, v, a = cycle.joints(0, np.array([0.0]))
    goal = q[biped.index, 0], v[biped.index, 0], a[biped.index, 0]
    motion = made.spec.end(biped, step, which.startswith(START), goal)
    found, _ = plan_nearby(made.planner, motion, settings, replace(thawed(warm), gait=cycle))
    return _finished(made, found, key_of(point))


def _finished(made: _Made, found: PlanResult, origin: str) -> Done:
    if found.gait is None:
        return Record(status="failed", reason=found.reason[:2000], iterations=found.iterations, origin=origin), b"", b""
    verdict = verify(found.gait, made.planner.biped.robot)
    if not verdict.ok:
        text = "; ".join(verdict.problems[:2])[:2000]
        return Record(status="failed", reason=text, iterations=found.iterations, origin=origin), b"", b""
    gait = (json.dumps(gait_document(found.gait), separators=(",", ":")) + "\n").encode()
    warm = frozen(found)
    record = Record(
        status="certified",
        objective=found.objective,
        iterations=found.iterations,
        origin=origin,
        parameters=found.gait.motion.parameters,
        gait=digest(gait),
        warm=digest(warm),
    )
    return record, gait, warm


def frozen(result: PlanResult) -> bytes:
    """What a neighbour starts from, as bytes that are the same for the same result."""
    assert result.solution is not None
    file = io.BytesIO()
    np.savez(
        file,
        x=result.x,
        bounds=np.array([(item.phase, item.bound) for item in result.imposed], dtype=np.int64).reshape(-1, 2),
        times=np.array([(item.time, item.tighten) for item in result.imposed]).reshape(-1, 2),
        borders=result.borders,
        solution=result.solution.x,
        multipliers=result.solution.multipliers,
    )
    return file.getvalue()


def thawed(content: bytes) -> PlanResult:
    """A result again, as far as a neighbour needs it.

    Raises:
        BadInput: the content is damaged.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as held:
            imposed = [
                ImposedBound(int(phase), int(bound), float(at), float(tighten))
                for (phase, bound), (at, tighten) in zip(held["bounds"], held["times"], strict=True)
            ]
            solution = Solution(held["solution"], True, "", 0, 0.0, held["multipliers"])
            return PlanResult(
                "solved", "", 0, {}, x=held["x"], imposed=imposed, borders=held["borders"], solution=solution
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise BadInput("warm", str(error)[:60], "what a plan left for its neighbours", "delete the file") from None


def build(
    spec: Spec,
    folder: Folder,
    *,
    jobs: int = 1,
    address: str = "",
    tell: Callable[[int, int], None] | None = None,
    notify: Callable[[str], None] | None = None,
) -> Built:
    """Plan what a folder does not hold yet; killed at any moment, the same call goes on.

    Args:
        spec: what is wanted.
        folder: where it goes.
        jobs: processes of this machine.
        address: of a Ray cluster instead.
        tell: called with the number of points done, and of all.
        notify: called once before the dynamics are compiled.

    Raises:
        BadInput: the robot cannot be planned for, the folder holds something else, or as :func:`workers`.
    """
    began, robot = time.perf_counter(), load_robot(spec.robot)
    planner = Planner(robot, notify)
    spec.motions(planner.biped)  # refuses what cannot be, before anything is written
    with workers(jobs, address) as crew:
        _ = planner.functions  # compiles once, before the processes would all do it
        folder.begin(spec, robot)
        with folder.alone():
            work = _Work(spec, folder, crew, tell)
            resumed = len(work.records)
            try:
                work.run()
                base = work.finish()
            except KeyboardInterrupt:
                return Built(work.records, "", resumed, time.perf_counter() - began, True)
    return Built(work.records, base, resumed, time.perf_counter() - began, False)


class _Work:
    """Points in an order in which every one comes after the neighbour that it starts from."""

    def __init__(
        self, spec: Spec, folder: Folder, crew: Workers, tell: Callable[[int, int], None] | None = None
    ) -> None:
        self.spec, self._folder, self._crew, self._tell = spec, folder, crew, tell
        self._text = json.dumps(spec.model_dump(mode="json"))
        found = {point: folder.get(key_of(point)) for point in spec.points}
        self.records = {key_of(point): record for point, record in found.items() if record is not None}

    def run(self) -> None:
        """Plan all points that are missing."""
        children: dict[Index | None, list[Index]] = {}
        for point in self.spec.points:
            children.setdefault(self.spec.parent(point), []).append(point)
        ready, open_ = list(children[None]), 0
        points = {key_of(point): point for point in self.spec.points}
        while ready or open_:
            for point in ready:
                key = key_of(point)
                if key in self.records:
                    continue
                self._crew.submit(key, plan_point, self._text, point, *self._origin(point))
                open_ += 1
            known = [point for point in ready if key_of(point) in self.records]
            ready = [child for point in known for child in children.get(point, [])]
            if ready or not open_:
                continue
            key = self._take()
            open_ -= 1
            ready = list(children.get(points[key], []))

    def _origin(self, point: Index) -> tuple[str, bytes]:
        """The nearest forebear that has a gait, and what it left."""
        parent = self.spec.parent(point)
        while parent is not None:
            key = key_of(parent)
            if self.records[key].certified:
                return key, self._folder.left(key)[1]
            parent = self.spec.parent(parent)
        return "", b""

    def _take(self) -> str:
        """Wait for the next result, and keep it."""
        key, (record, gait, warm) = self._crew.done()
        self._folder.put(key, record, gait, warm)
        self.records[key] = record
        if self._tell is not None:
            self._tell(len(self.records), len(self.spec.points) + 2 * max(len(self.spec.slope), 1))
        return str(key)

    def finish(self) -> str:
        """Plan start and stop for the first gait for which both exist, and on all slopes, and write the index.

        Returns:
            The gait's key; empty if there is none.
        """
        keys, ends = [key_of(point) for point in self.spec.points], list[str]()
        for point in self.spec.bases:
            ends = self._end([point])
            if ends and all(self.records[which].certified for which in ends):
                others = [at for at in self.spec.on_slopes(point) if at != point]
                self._folder.end(key_of(point), [*keys, *ends, *self._end(others)])
                return key_of(point)
        self._folder.end("", keys)
        return ""

    def _end(self, points: list[Index]) -> list[str]:
        """Plan the starts and stops of those points that have a gait; their keys."""
        missing, found = 0, list[str]()
        for point in points:
            key = key_of(point)
            if not self.records[key].certified:
                continue
            for which in end_keys(self.spec, point):
                found.append(which)
                held = self._folder.get(which)
                if held is not None and held.origin == key:
                    self.records[which] = held
                else:
                    self._crew.submit(which, plan_end, self._text, point, which, *self._folder.left(key))
                    missing += 1
        for _ in range(missing):
            self._take()
        return found


def failures(built: Built) -> list[dict[str, str]]:
    """What could not be planned, and why."""
    return [{"point": key, "reason": item.reason} for key, item in built.records.items() if not item.certified]
