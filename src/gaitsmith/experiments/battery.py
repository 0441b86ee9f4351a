"""``gaitsmith bench battery``: every trial of a set, judged by named limits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import loop_identity, run_all, why_unfit
from gaitsmith.experiments.limits import QUANTITIES, Finding, Judgement, judge, measure, shown
from gaitsmith.experiments.options import BatteryOptions
from gaitsmith.experiments.result import Progress, Result, silent
from gaitsmith.experiments.sets import Trial, load_set
from gaitsmith.experiments.store import Store
from gaitsmith.simulation import Scenario, Summary


def run_battery(options: BatteryOptions, progress: Progress = silent) -> Result:
    """Run the trials of a set; ``battery.json`` is written to the folder of results too.

    A trial that needs an input or a preset that the robot's card does not have is skipped, and says so.

    Raises:
        BadInput: unknown set, trial or preset, or the robot or the folder cannot be used.
    """
    chosen = load_set(options.set, options.robot, options.preset, options.gait, options.engine)
    loaded, trials = chosen.robot, _chosen(chosen.trials, options.only)
    store = Store(options.out)
    unfit = {trial.name: reason for trial in trials if (reason := why_unfit(trial.scenarios, loaded))}
    wanted = [scenario for trial in trials if trial.name not in unfit for scenario in trial.scenarios]
    episodes = run_all(wanted, loaded, store, jobs=options.jobs, progress=progress, what="walking")
    outcomes = [
        TrialOutcome(trial, tuple((s, episodes.found.get(s)) for s in trial.scenarios), unfit.get(trial.name))
        for trial in trials
    ]
    counts = Counter(outcome.verdict for outcome in outcomes)
    document = {
        "robot": loaded.card.name,
        "preset": options.preset,
        "set": chosen.name,
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


def _chosen(trials: Sequence[Trial], only: Sequence[str]) -> list[Trial]:
    """The trials with these names, in the set's order."""
    names = [trial.name for trial in trials]
    for name in only:
        if name not in names:
            raise BadInput("--only", name, "one of " + ", ".join(names))
    return [trial for trial in trials if not only or trial.name in only]


@dataclass(frozen=True)
class TrialOutcome:
    """A trial and what became of it.

    Attributes:
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
        trial, allowed = self.trial, len(self.episodes) - self.trial.least
        return judge(trial.limits, trial.entry.report, measured, falls, allowed=allowed, judged=trial.entry.judged)

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
        falls = [(summary.seed, summary.fall) for summary in self.finished if summary.fall is not None]
        where = f"{self.trial.name}, seed"
        return [f"{where} {seed}: fell at {fall.time:.2f} s, {fall.phase}: {fall.reason}" for seed, fall in falls]

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
                _episode(scenario.seed, summary) for scenario, summary in self.episodes if summary is not None
            ],
        }


def _episode(seed: int, summary: Summary) -> dict[str, Any]:
    return {"seed": seed, "measures": measure(summary), "fall": summary.fall.model_dump() if summary.fall else None}


def _words(finding: Finding) -> str:
    """A worst value, marked if it breaks its limit."""
    mark = " ✗" if finding.verdict() == "miss" else ""
    return f"{QUANTITIES[finding.quantity].label} {shown(finding.quantity, finding.value)}{mark}"
