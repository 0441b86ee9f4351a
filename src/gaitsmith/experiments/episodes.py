"""Many episodes, each run once: found in the store, or run here or on other processes and stored at once."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from itertools import islice
from pathlib import Path

from gaitsmith.compiled.cache import source_key
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.experiments.result import Progress, silent
from gaitsmith.experiments.store import Store
from gaitsmith.files import read_bounded
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario, Simulation, Summary, run_episode
from gaitsmith.simulation.remote import identity_of
from gaitsmith.simulation.scenario import check_scenario
from gaitsmith.work.workers import workers

_LOOP = "gaitsmith.simulation.episode"
_LARGEST_GAIT = 100_000_000  # bytes
_Done = tuple[Scenario, str, Summary | None]
_Source = Generator[_Done, None, None]
_Asked = Callable[[Scenario], bool]


class RobotChanged(GaitsmithError):
    """Code or robot files changed between the beginning of an experiment and one of its episodes."""


def loop_identity(robot: Robot) -> str:
    """Hash of the closed loop's source and versions, and of the robot's files with all their presets."""
    parts = (source_key(_LOOP), version("mujoco"), robot.content_hash)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]


def episode_key(loop: str, scenario: Scenario) -> str:
    """Key of one episode.

    Args:
        loop: from :func:`loop_identity`.
        scenario: names and paths of the robot, the gait and the policy do not count, their contents do.
    """
    fields = scenario.model_dump(mode="json", exclude={"robot"})
    fields["gait"] = [_content(path) for path in scenario.gait]
    if scenario.library:
        fields["library"] = _content(Path(scenario.library) / "index.json")
    if scenario.controller:
        fields["controller"] = identity_of(scenario.controller)
    if scenario.policy:
        fields["policy"] = _content(scenario.policy)
    text = json.dumps(fields, sort_keys=True, allow_nan=False)
    return hashlib.sha256(f"{loop}\n{text}".encode()).hexdigest()[:32]


def _content(path: str | Path) -> str:
    return hashlib.sha256(read_bounded(path, _LARGEST_GAIT)).hexdigest()


def why_unfit(scenarios: Iterable[Scenario], robot: Robot) -> str:
    """Why a robot cannot run these scenarios; empty if it can."""
    try:
        for scenario in scenarios:
            check_scenario(scenario, robot)
    except BadInput as error:
        return f"{error.field} {error.value} is not {error.valid}"
    return ""


@dataclass(frozen=True)
class Episodes:
    """Finished episodes.

    Attributes:
        found: summary of every scenario that is finished.
        interrupted: whether Ctrl-C left some out.
        resumed: how many came from the store.
    """

    found: dict[Scenario, Summary]
    interrupted: bool
    resumed: int

    def notes(self, total: int, store: Store) -> list[str]:
        """What is to be said of ``total`` episodes and where they are kept, a line each."""
        lines = []
        if self.interrupted:
            done = f"interrupted after {len(self.found)} of {total} episodes"
            lines.append(f"{done}; the same command goes on from there")
        if self.resumed:
            lines.append(f"{self.resumed} of {total} episodes found in {store.path}")
        if store.damaged:
            lines.append(f"{store.damaged} damaged lines in {store.path} were passed over")
        return lines


def run_all(
    scenarios: Iterable[Scenario],
    robot: Robot,
    store: Store,
    *,
    jobs: int = 1,
    address: str = "",
    progress: Progress = silent,
    what: str = "episodes",
    needless: Callable[[Scenario, Mapping[Scenario, Summary]], bool] = lambda scenario, found: False,
) -> Episodes:
    """Run every scenario that the store does not hold yet.

    Args:
        scenarios: all of the same robot; repeated ones run once.
        robot: as the scenarios' ``robot`` loads it.
        store: asked first; every episode is added as soon as it is finished.
        jobs: processes, each with one thread.
        address: of a Ray cluster instead, whose nodes have the robot's files at the same place.
        needless: told what is finished: whether a scenario is not of interest any more, and left out.

    Raises:
        BadInput: ``jobs`` below 1, or a scenario that does not fit the robot.
        RobotChanged: the robot or the code changed meanwhile; what was finished before is kept.
    """
    if jobs < 1:
        raise BadInput("--jobs", jobs, "a whole number from 1")
    wanted = list(dict.fromkeys(scenarios))
    for scenario in wanted:
        check_scenario(scenario, robot)
    loop = loop_identity(robot)
    keys = {scenario: episode_key(loop, scenario) for scenario in wanted}
    found = {scenario: summary for scenario in wanted if (summary := store.get(keys[scenario])) is not None}
    pending = [scenario for scenario in wanted if scenario not in found]
    resumed, interrupted = len(found), False
    progress(resumed, len(wanted), what)
    alone = not address and min(jobs, len(pending)) <= 1

    def wants(scenario: Scenario) -> bool:
        return not needless(scenario, found)

    source = _here(pending, wants, robot, loop) if alone else _elsewhere(pending, wants, robot, jobs, address)
    try:
        for scenario, identity, summary in source:
            if summary is None:
                interrupted = True
                break
            if identity != loop:
                raise RobotChanged("the code or the robot's files changed meanwhile; run again, finished runs are kept")
            store.add(keys[scenario], scenario, summary)
            found[scenario] = summary
            progress(len(found), len(wanted), what)
    except KeyboardInterrupt:
        interrupted = True
    finally:
        source.close()
    return Episodes(found, interrupted, resumed)


def _here(pending: Sequence[Scenario], wants: _Asked, robot: Robot, loop: str) -> _Source:
    """Run in this process; Ctrl-C ends the episode, which then has no summary."""
    for scenario in filter(wants, pending):
        episode = run_episode(scenario, robot=robot, record=False)
        yield scenario, loop, None if episode.interrupted else episode.summary


@cache
def _loaded(name: str) -> tuple[Robot, str]:
    """A worker's robot, and the identity of what the worker runs."""
    robot = load_robot(name)
    return robot, loop_identity(robot)


def _remote(scenario: Scenario) -> _Done:
    """One episode in a worker process."""
    robot, identity = _loaded(scenario.robot)
    return scenario, identity, run_episode(scenario, robot=robot, record=False).summary


def _elsewhere(pending: Sequence[Scenario], wants: _Asked, robot: Robot, jobs: int, address: str) -> _Source:
    """Run on ``jobs`` processes, or a cluster, longest first; a process that dies ends the experiment."""
    longest_first = sorted(pending, key=lambda scenario: -scenario.duration)
    if not longest_first:
        return
    Simulation(longest_first[0], robot=robot, record=False)  # compile once, not in every process at the same time
    ahead = len(pending) if address else 2 * jobs  # given out at a time: of a cluster nobody knows how much it does
    with workers(min(jobs, len(pending)), address) as crew:
        waiting, running = filter(wants, longest_first), 0
        while True:
            for scenario in islice(waiting, ahead - running):
                crew.submit(scenario.robot, _remote, scenario)
                running += 1
            if not running:
                return
            running -= 1
            yield crew.done()[1]
