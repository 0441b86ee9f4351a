"""Gains found by search against a crash test, and what they gain on seeds that the search has not seen."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.adoption.options import TuneOptions
from gaitsmith.adoption.search import GAINS, ROUND, Candidate, drawn
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.documents import toml
from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import run_all
from gaitsmith.experiments.random_walks import interval
from gaitsmith.experiments.result import Progress, silent
from gaitsmith.experiments.store import Store
from gaitsmith.experiments.withstanding import pushed_walks, score, stood, withstood
from gaitsmith.files import write_bytes_atomic, write_text_atomic
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.card_file import OLD_VERSION, read_card
from gaitsmith.robots.loading import build_robot, card_path
from gaitsmith.robots.safety import CardFolder
from gaitsmith.simulation import Summary
from gaitsmith.work.workers import address_of

TUNED = {
    **GAINS,
    "foothold.reach": (0.8, 1.25),
    "foothold.spread": (0.8, 1.25),
    "step_time.foot_speed": (0.7, 1.5),
}
"""Factors on the preset's gains, and their ranges."""
HELD_OUT = 1_000_000
"""Seeds of the search lie below, those that it is judged by from here on."""
_WIDTHS = (0.35, 0.12)  # of a factor's range: how far from the best candidates are drawn, in turn


@dataclass(frozen=True)
class Tuning:
    """What came of it.

    Attributes:
        card: folder of the card with the found gains as a preset; None if they are not better, or not found yet.
        interrupted: whether Ctrl-C cut it short; the same command goes on from there.
    """

    document: dict[str, Any]
    card: Path | None
    interrupted: bool = False


class _Stopped(Exception):
    """Ctrl-C; what was finished is in the store."""


class _Bench:
    """Runs candidates as presets of a copy of the card."""

    def __init__(self, options: TuneOptions, progress: Progress) -> None:
        self._options, self._progress = options, progress
        self._address = address_of(options.engine, options.address)
        path = card_path(options.robot)
        card, self._text = read_card(path)
        if card.schema_version == OLD_VERSION:
            raise BadInput("--robot", f"a card of schema_version {OLD_VERSION}", "a newer card", "see docs/cards.md")
        folder = CardFolder(path.parent.resolve(), path.name)
        self.robot = build_robot(card, self._text, folder)
        self._files = folder.contents
        if options.preset not in self.robot.card.presets:
            valid = "one of " + ", ".join(sorted(self.robot.card.presets))
            raise BadInput("--preset", options.preset, valid)
        self._own = self.robot.card.presets[options.preset].model_dump(mode="json", exclude_none=True)
        self.gains = preset_parameters(self.robot, robot_scale(self.robot), options.preset).model_dump()
        taken = self.robot.card.presets
        self.name = next(name for k in range(1, 100) if (name := f"tuned_{k}" if k > 1 else "tuned") not in taken)
        self.store = Store(options.out)
        self._stage, self._rounds = self.store.path.with_name(f"candidates_{secrets.token_hex(4)}"), count()

    def tables(self, candidate: Candidate) -> dict[str, Any]:
        """The preset's groups: the card's own, and over them what the candidate changes."""
        found = candidate.gains(self.gains)
        return {name: {**self._own.get(name, {}), **found.get(name, {})} for name in {**self._own, **found}}

    def write(self, folder: Path, presets: Mapping[str, Candidate], comment: str) -> None:
        """The card with more presets, and all files that it reads."""
        for relative, content in self._files.items():
            (folder / relative).parent.mkdir(parents=True, exist_ok=True)
            write_bytes_atomic(folder / relative, content)
        lines = [f"# {comment}"]
        for name, candidate in presets.items():
            lines += [f"[presets.{name}]", *(f"{group} = {toml(v)}" for group, v in self.tables(candidate).items()), ""]
        write_text_atomic(folder / "card.toml", self._text.decode("utf-8") + "\n" + "\n".join(lines))

    def run(self, candidates: list[Candidate], seeds: range, what: str) -> list[list[Summary]]:
        """Summaries of every candidate, on the same walks.

        Raises:
            _Stopped: Ctrl-C.
        """
        named = {f"{self.name}_try_{k}": candidate for k, candidate in enumerate(candidates)}
        stage = self._stage / str(next(self._rounds))  # a worker keeps what it has loaded by its path
        self.write(stage, named, "Candidates of `gaitsmith tune`.")
        staged = load_robot(stage)
        walks = [
            pushed_walks(seeds, staged, {"robot": str(stage.resolve()), "preset": name, "rest_before": 1.0})
            for name in named
        ]
        wanted = [scenario for group in walks for scenario in group]
        jobs, address = self._options.jobs, self._address
        try:
            episodes = run_all(
                wanted, staged, self.store, progress=self._progress, what=what, jobs=jobs, address=address
            )
        finally:
            shutil.rmtree(self._stage, ignore_errors=True)
        if episodes.interrupted:
            raise _Stopped
        return [[episodes.found[scenario] for scenario in group] for group in walks]


def tune(options: TuneOptions, progress: Progress = silent) -> Tuning:
    """Search for gains that withstand stronger pushes, then compare them with today's on held-out seeds.

    Candidates are factors on the preset's gains, drawn around the best one so far (eight at a time, so that they can
    be run on several processes); all are put to the same walks. The store keeps every walk: a search that was stopped,
    or that is asked for more candidates, repeats none.

    Raises:
        BadInput: the robot, the preset or the folder cannot be used.
    """
    bench = _Bench(options, progress)
    random = np.random.default_rng(options.seed)
    first = options.seed * options.runs % (HELD_OUT - options.runs)
    seeds = range(first, first + options.runs)
    today = Candidate(dict.fromkeys(TUNED, 1.0))
    best, tried = today, 0
    try:
        (summaries,) = bench.run([today], seeds, "today's gains")
        at_first = highest = score(summaries)
        while tried < options.candidates:
            number = min(ROUND, options.candidates - tried)
            made = [drawn(random, TUNED, best, _WIDTHS[k % len(_WIDTHS)]) for k in range(number)]
            what = f"{tried} of {options.candidates} candidates, best withstands {highest:.3f} (today's {at_first:.3f})"
            for candidate, found in zip(made, bench.run(made, seeds, what), strict=True):
                if score(found) > highest:
                    best, highest = candidate, score(found)
            tried += number
        judged = range(HELD_OUT + first, HELD_OUT + first + options.held_out)
        before, after = bench.run([today, best], judged, "held-out seeds")
    except _Stopped:
        return Tuning({**_head(options, bench.robot), "tried": tried, "interrupted": True}, None, True)
    gained = withstood(after) - withstood(before)
    better, worse = (sum(stood(a) and not stood(b) for a, b in pairs) for pairs in _paired(after, before))
    low, high = interval(better, better + worse) if better + worse else (0.0, 1.0)
    card = None
    if gained > 0.0:
        card = bench.store.path.with_name("card")
        comment = (
            f"Found by `gaitsmith tune` with seed {options.seed}: {withstood(before):.3f} m√(gH) withstood before, "
        )
        bench.write(
            card, {bench.name: best}, comment + f"{withstood(after):.3f} after, on {len(after)} held-out seeds."
        )
        load_robot(card)
    document = {
        **_head(options, bench.robot),
        "tried": tried,
        "factors": {name: float(f"{factor:.4g}") for name, factor in best.factors.items()},
        "search": {"before": round(at_first, 5), "after": round(highest, 5), "seeds": [seeds.start, seeds.stop]},
        "held_out": {
            "before": withstood(before),
            "after": withstood(after),
            "gained": gained,
            "better": better,
            "worse": worse,
            "share_better": [low, high],
            "seeds": [judged.start, judged.stop],
        },
        "preset": bench.name if card else None,
        "card": str(card) if card else None,
        "interrupted": False,
    }
    return Tuning(document, card)


def _head(options: TuneOptions, robot: Robot) -> dict[str, Any]:
    return {"robot": robot.card.name, "against": "crash", "base": options.preset, "seed": options.seed}


def _paired(after: list[Summary], before: list[Summary]) -> tuple[list[tuple[Summary, Summary]], ...]:
    """The same walks with both gains, either first."""
    return list(zip(after, before, strict=True)), list(zip(before, after, strict=True))
