"""``gaitsmith bench battery``: every trial of the battery, judged by named limits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.identity import loop_identity
from gaitsmith.experiments.limits import QUANTITIES, Finding, Judgement, judge, shown
from gaitsmith.experiments.measures import measure
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.store import Store
from gaitsmith.experiments.trials import Trial, battery_trials
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario, Summary
from gaitsmith.simulation.scenario import check_scenario


def run_battery(
    robot: str = "bhr_b2",
    preset: str = "default",
    only: Sequence[str] = (),
    jobs: int = 1,
    out: str | Path = "runs/bench",
    progress: Progress = silent,
) -> Result:
    """Run the trials of :func:`gaitsmith.experiments.battery_trials`.

    A trial that needs a gait or a preset that the robot's card does not have is skipped, and says so.

    Args:
        robot: name or path.
        preset: control parameters of the card, for the trials that do not name their own.
        only: names of the trials to run; all if empty.
        jobs: processes.
        out: folder of the finished episodes; ``battery.json`` is written there too.
        progress: told of the episodes done.

    Raises:
        BadInput: unknown trial or preset, or the robot or the folder cannot be used.
    """
    trials = _chosen(only)
    loaded = load_robot(robot)
    if preset not in loaded.card.presets:
        raise BadInput("--preset", preset, "one of " + ", ".join(sorted(loaded.card.presets)))
    store = Store(out)
    planned = {trial.name: trial.scenarios(robot, preset) for trial in trials}
    unfit = {name: reason for name, scenarios in planned.items() if (reason := _unfit(scenarios, loaded))}
    wanted = [scenario for name, scenarios in planned.items() if name not in unfit for scenario in scenarios]
    episodes = run_all(wanted, loaded, store, jobs=jobs, progress=progress, what="walking")
    outcomes = [
        TrialOutcome(trial, tuple((s, episodes.found.get(s)) for s in planned[trial.name]), unfit.get(trial.name))
        for trial in trials
    ]
    counts = Counter(outcome.verdict for outcome in outcomes)
    document = {
        "robot": loaded.card.name,
        "preset": preset,
        "identity": loop_identity(loaded),
        "trials": [outcome.document() for outcome in outcomes],
        "verdicts": dict(counts),
        "interrupted": episodes.interrupted,
    }
    notes = [line for outcome in outcomes for line in outcome.notes()]
    notes += episodes.notes(len(wanted), store)
    notes.append(", ".join(f"{count} {verdict}" for verdict, count in counts.most_common()))
    columns = ("trial", "target", "measured", "verdict")
    result = Result(document, columns, tuple(o.row() for o in outcomes), tuple(notes), episodes.interrupted)
    result.write(store.path.with_name("battery.json"))
    return result


def _chosen(only: Sequence[str]) -> list[Trial]:
    """The trials with these names, in the battery's order."""
    trials = {trial.name: trial for trial in battery_trials()}
    for name in only:
        if name not in trials:
            raise BadInput("--only", name, "one of " + ", ".join(trials))
    return [trial for name, trial in trials.items() if not only or name in only]


def _unfit(scenarios: Sequence[Scenario], robot: Robot) -> str:
    """Why a robot cannot run these scenarios; empty if it can."""
    try:
        for scenario in scenarios:
            check_scenario(scenario, robot)
    except BadInput as error:
        return f"{error.field} {error.value} is not {error.valid}"
    return ""


@dataclass(frozen=True)
class TrialOutcome:
    """A trial and what became of it.

    Attributes:
        trial: the trial.
        episodes: each scenario with its summary, None if it was not run.
        unfit: why the robot cannot run it, None if it can.
    """

    trial: Trial
    episodes: tuple[tuple[Scenario, Summary | None], ...]
    unfit: str | None = None

    @property
    def finished(self) -> list[Summary]:
        """Summaries of the episodes that were run."""
        return [summary for _, summary in self.episodes if summary is not None]

    @property
    def judgement(self) -> Judgement:
        """Verdict and worst values over the episodes that were run."""
        finished = self.finished
        falls = sum(summary.fell for summary in finished)
        measured = [measure(summary) for summary in finished]
        return judge(self.trial.limits, self.trial.reported, measured, falls, judged=self.trial.judged)

    @property
    def verdict(self) -> str:
        """As in the table; a trial with episodes missing has not passed."""
        if self.unfit is not None:
            return "skipped"
        verdict = self.judgement.verdict
        return "not run" if verdict != "miss" and len(self.finished) < len(self.episodes) else verdict

    def row(self) -> tuple[str, ...]:
        """In words."""
        judgement = self.judgement
        words = []
        if self.finished:
            words = [f"{judgement.falls} of {len(self.finished)} fell" if judgement.falls else "no fall"]
        words += [_words(finding) for finding in judgement.findings if finding.value is not None]
        return self.trial.name, self.trial.target(), "; ".join(words), self.verdict

    def notes(self) -> list[str]:
        """What went wrong, a line each."""
        if self.unfit is not None:
            return [f"{self.trial.name}: skipped, {self.unfit}"]
        return [
            f"{self.trial.name}, seed {summary.seed}: fell at {summary.fall.time:.2f} s, {summary.fall.phase}: "
            f"{summary.fall.reason}"
            for summary in self.finished
            if summary.fall is not None
        ]

    def document(self) -> dict[str, Any]:
        """As plain data."""
        judgement = self.judgement
        return {
            "name": self.trial.name,
            "target": self.trial.target(),
            "verdict": self.verdict,
            "skipped": self.unfit,
            "falls": judgement.falls,
            "episodes_run": len(self.finished),
            "findings": [finding.document() for finding in judgement.findings],
            "scenario": self.episodes[0][0].model_dump(mode="json", exclude_none=True, exclude={"seed"}),
            "episodes": [
                {
                    "seed": scenario.seed,
                    "measures": measure(summary),
                    "fall": summary.fall.model_dump() if summary.fall else None,
                }
                for scenario, summary in self.episodes
                if summary is not None
            ],
        }


def _words(finding: Finding) -> str:
    """A worst value, marked if it breaks its limit."""
    mark = " ✗" if finding.verdict() == "miss" else ""
    return f"{QUANTITIES[finding.quantity].label} {shown(finding.quantity, finding.value)}{mark}"
