"""``gaitsmith plan sweep`` and ``gaitsmith plan --claims``: many gaits planned and compared."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from gaitsmith.cli.dispatch import DONE, NOT_SOLVED, Outcome, Table, Text
from gaitsmith.cli.inputs import named_robot
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    from gaitsmith.synthesis.proof.claims import Claim
    from gaitsmith.synthesis.requests.sweep import Cell

_WIDE = {"torso_pitch": 0.5, "torso_roll": 0.3, "torso_yaw": 0.3}
_USUAL = {"length": 0.20, "period": 0.5}
_CHOICES: tuple[tuple[str, dict[str, float], dict[str, float]], ...] = (
    ("by\ndefault", {}, _USUAL),
    ("torso 0.5,\n0.3, 0.3 rad", _WIDE, _USUAL),
    ("0.26 m\nin 0.65 s", {}, {"length": 0.26, "period": 0.65}),
    ("wide torso,\nflat toe-off", _WIDE, _USUAL | {"toe_off": 0.05}),
)
"""What the claims are looked at under: bounds besides the defaults, and the dynamic step, at 0.40 m/s."""


def sweep(robot: str, jobs: int) -> Outcome:
    """Run the grid and report it."""
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis.requests.sweep import sweep as run
    from gaitsmith.synthesis.requests.sweep import sweep_document

    named_robot(robot)
    with Display() as display:
        cells = run(robot, jobs, lambda done, total: display.show("sweep", f"{done} of {total}", done, total))
    document = sweep_document(cells)
    return Outcome(DONE if document["share"] >= 0.95 else NOT_SOLVED, document, _sweep_lines(cells, document))


def _sweep_lines(cells: list[Cell], document: dict[str, Any]) -> Iterator[Text]:
    warm = f"{document['warm']} planned from the period before"
    yield f"{document['certified']} of {document['reachable']} gaits within reach certified, {warm}"
    headings = ("speed\nm/s", "period\ns", "step\nm", "status", "objective", "iterations", "s", "ZMP\nmm")
    forms = {"speed": ".3f", "period": ".2f", "length": ".3f", "status": "", "objective": ".1f", "iterations": ""}
    forms |= {"time_s": ".2f", "zmp_margin_mm": ".1f"}
    yield Table(headings, [[format(getattr(cell, key), form) for key, form in forms.items()] for cell in cells], (3,))
    for cell in cells:
        if cell.status == "failed":
            yield f"{cell.speed:.3f} m/s, {cell.period:.2f} s: {cell.reason}"


def claims(robot_name: str) -> Outcome:
    """Plan the static and the dynamic gait, compare them with section 5, and say what other choices change."""
    from gaitsmith.cli.display import Display
    from gaitsmith.synthesis import Bounds, Planner, Request, Settings, StepParameters, answer
    from gaitsmith.synthesis.proof.claims import paper_claims

    robot = named_robot(robot_name)
    choices: list[tuple[str, dict[str, bool]]] = []
    items: list[Claim] = []
    with Display() as display:
        planner = Planner(robot, display.slow)
        if planner.biped.lines:
            valid = "a robot whose soles have an area"
            raise BadInput("--robot", robot_name, valid, "the paper's steps turn about heel and toe")
        for choice, bounds, dynamic in _CHOICES:
            gaits = []
            for step in (StepParameters(0.15, 1.0), StepParameters(**dynamic)):
                settings = Settings(bounds=Bounds(**bounds))
                found = answer(planner, Request("cyclic", step, settings=settings), display.iteration)
                if found.gait is not None:
                    gaits.append(found.gait)
                elif not choices:
                    reason = f"a step of {step.length:g} m in {step.period:g} s: {found.main.reason}"
                    display.say(f"{found.main.status}: {reason}")
                    return Outcome(NOT_SOLVED, _document(found.main.status, reason, [], []), [])
            display.show("comparing")
            told = paper_claims(gaits[0], gaits[1], robot) if len(gaits) == 2 else []
            items = items or told
            choices.append((choice, {item.claim: item.holds for item in told}))

    words = {True: "holds", False: "does not", None: "no gait"}
    rows = [[item.claim, item.found, *(words[held.get(item.claim)] for _, held in choices)] for item in items]
    shown = Table(("the paper's claim", "here, by default", *(name for name, _ in choices)), rows, left=(0, 1))
    counts = ", ".join(f"{sum(held.values())} of {len(items)} {name}" for name, held in choices).replace("\n", " ")
    others = [{"choice": name.replace("\n", " "), "holds": held} for name, held in choices]
    return Outcome(
        DONE, _document("solved", "", [item.as_dict() for item in items], others), [shown, f"hold: {counts}"]
    )


def _document(status: str, reason: str, claims: list[dict[str, Any]], choices: list[dict[str, Any]]) -> dict[str, Any]:
    return {"motion": "claims", "status": status, "reason": reason, "claims": claims, "choices": choices}
