"""``gaitsmith adopt``: a card for a robot that nobody described yet, tested."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.adoption.options import AdoptOptions
from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import BAD_INPUT, DONE, FELL, Outcome, Table, Text, printable
from gaitsmith.cli.inputs import gait_units

if TYPE_CHECKING:
    from gaitsmith.adoption.adopting import Adoption


class AdoptArguments(AdoptOptions, Arguments):
    """Make a card for a biped from its model alone: legs, soles and frames are inferred, and it is tested.

    It writes a folder with the card, copies of the model's files, and a picture. Then the robot stands, walks at
    0.1 m/s, and is measured: speeds, heights, periods and pushes within which it walks.
    """

    model: Annotated[
        str,
        Positional(
            "A URDF or MJCF file, or a name of robot_descriptions, mujoco-menagerie or example-robot-data",
            metavar="MODEL",
        ),
    ]


def adopt(words: list[str], program: str) -> Outcome:
    """Run ``adopt``.

    Exit codes: 0 adopted and walks; 1 a card was written but a test fails; 2 refused, or something has to be asked.
    """
    options = parse(AdoptArguments, words, program)
    from gaitsmith.adoption.adopting import adopt as run
    from gaitsmith.cli.display import Display
    from gaitsmith.errors import BadInput

    if len(options.feet) == 1:
        raise BadInput("--feet", options.feet[0], "two bodies: --feet LEFT --feet RIGHT")
    with Display("loading (the first time compiles)") as display:
        adoption = run(options, display.advance)
    code = BAD_INPUT if adoption.card is None else DONE if adoption.ok else FELL
    document = adoption.document | {"advice": _advice(adoption)}
    if adoption.card is None:
        sys.stderr.write(f"gaitsmith: {printable(adoption.reason)}\n")
        document |= {"error": {"kind": "bad input", "message": adoption.reason}}
    return Outcome(code, document, _lines(adoption, document))


def _lines(adoption: Adoption, document: dict[str, Any]) -> Iterator[Text]:
    """Legs, tests and sheet; what to do next."""
    for leg in document["legs"]:
        pairs = zip(leg["joints"], leg["roles"], strict=True)
        yield f"{leg['name']} leg: {', '.join(f'{name} ({role})' for name, role in pairs)}"
    for asked in document["asked"]:
        yield f"candidates of {asked['flag']}: {' | '.join(asked['candidates']) or 'none, see --help'}"
    if adoption.card is None:
        return
    for leg in ("left", "right"):
        sole = next(
            entry["value"] for entry in document["inferred"] if entry["entry"] == f"legs[{leg == 'right':d}].sole"
        )
        yield f"{leg} sole: {_sole(sole)}"
    yield from _assumed(document["assumed"])
    yield from (f"note: {note}" for note in document["notes"])
    yield from (test.line() for test in adoption.tests)
    if document["search"]["rollouts"]:
        yield f"search: {document['search']['rollouts']} candidates, {document['search']['seconds']:g} s"
    if rows := _rows(document["sheet"] or {}):
        yield Table(("walked", "from", "to"), rows)
    if document["sheet"]:
        torque, velocity = document["sheet"]["torque_reserve"], document["sheet"]["velocity_reserve"]
        yield f"left of the legs' limits at 0.1 m/s: {torque:.0%} of torque, {velocity:.0%} of velocity"
    yield f"written: {adoption.card.parent} (card.toml, the model's files, robot.png: look at it)"
    yield document["advice"]


def _sole(sole: dict[str, Any]) -> str:
    """Kind and size."""
    kind, half = sole["kind"], sole.get("half_width", 0.0)
    heel, toe = sole.get("heel", 0.0), sole.get("toe", 0.0)
    if points := sole.get("points"):
        kind, half = f"polygon of {len(points)} corners", max(abs(y) for _, y in points)
        heel, toe = -min(x for x, _ in points), max(x for x, _ in points)
    width = f", {200.0 * half:.3g} cm wide" if half else ""
    return f"{kind}, {100.0 * heel:.3g} cm behind and {100.0 * toe:.3g} cm ahead of the ankle{width}"


def _assumed(entries: list[dict[str, Any]]) -> Iterator[str]:
    """The gait in one line, other entries in one each."""
    gait = [entry for entry in entries if entry["entry"].startswith("gait.")]
    yield from (f"assumed: {e['entry']} = {e['value']}: {e['from']}" for e in entries if e not in gait)
    if gait:
        words = ", ".join(f"{entry['entry'].removeprefix('gait.')} {entry['value']}" for entry in gait)
        yield f"assumed, as for a robot of this size: gait with {words}"


def _rows(sheet: dict[str, Any]) -> list[tuple[str, ...]]:
    units = gait_units()
    rows = [
        (f"{key}, {units.get(key, '')}", *(f"{v:g}" for v in v2)) for key, v2 in sheet.items() if isinstance(v2, list)
    ]
    return rows + [(f"push {key}, N·s", "", f"{value:g}") for key, value in sheet.get("push", {}).items()]


def _advice(adoption: Adoption) -> str:
    """What to do next."""
    if adoption.card is None:
        return adoption.reason
    failed = [test.name for test in adoption.tests if not test.ok]
    if not failed:
        return f"it walks: gaitsmith walk --robot {adoption.card.parent} --speed 0.1"
    return {
        "soles": "the soles do not carry the weight: compare the picture's soles with the robot's shapes, give --sole",
        "standing": "it does not stand still: check masses, limits and soles in the card, then gaitsmith robots check",
        "walk": "it does not walk: a larger --search, another --seed, or docs/tuning.md",
    }[failed[0]]
