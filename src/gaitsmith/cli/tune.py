"""``gaitsmith tune``: gains found by search against a crash test."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from gaitsmith.adoption.options import TuneOptions
from gaitsmith.cli.arguments import Arguments, parse
from gaitsmith.cli.dispatch import DONE, INTERRUPTED, NOT_SOLVED, Outcome, Text
from gaitsmith.documents import About

if TYPE_CHECKING:
    from gaitsmith.adoption.tuning import Tuning


class TuneArguments(TuneOptions, Arguments):
    """Search for gains with which a robot withstands stronger pushes, and measure them on seeds not searched on.

    Every candidate walks the same random walks, with pushes of all strengths. The best one is compared with today's
    gains on other seeds; if it is better, a card with it as a preset is written. A search that was stopped goes on.
    """

    against: Annotated[Literal["crash"], About("What the gains are to withstand")] = "crash"


def tune(words: list[str], program: str) -> Outcome:
    """Run ``tune``.

    Exit codes: 0 better gains found; 3 none; 130 Ctrl-C.
    """
    options = parse(TuneArguments, words, program)
    from gaitsmith.adoption.tuning import tune as run
    from gaitsmith.cli.display import Display

    with Display("loading (the first time compiles)") as display:
        tuning = run(options, display.advance)
    code = INTERRUPTED if tuning.interrupted else DONE if tuning.card is not None else NOT_SOLVED
    return Outcome(code, tuning.document, _lines(tuning))


def _lines(tuning: Tuning) -> Iterator[Text]:
    """What was found."""
    found = tuning.document
    if tuning.interrupted:
        yield f"interrupted after {found['tried']} candidates; the same command goes on from there"
        return
    judged = found["held_out"]
    before, after = (f"{judged[name]:.3f}" for name in ("before", "after"))
    yield f"mean strength of push withstood on held-out seeds, over m√(gH): {before} before, {after} after"
    low, high = judged["share_better"]
    yield (
        f"of the walks that end differently, {judged['better']} stand only with the new gains, {judged['worse']} only "
        f"with today's (share better {low:.0%} to {high:.0%}, 95 %)"
    )
    changed = {name: factor for name, factor in found["factors"].items() if factor != 1.0}
    if changed:
        yield "factors: " + ", ".join(f"{name} {factor:.3g}" for name, factor in changed.items())
    if tuning.card is None:
        yield "nothing better was found: more --candidates, more --runs, or another --seed"
    else:
        yield f"written: {tuning.card / 'card.toml'}; gaitsmith walk --robot {tuning.card} --preset {found['preset']}"
