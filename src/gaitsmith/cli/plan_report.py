"""What ``gaitsmith plan`` and ``gaitsmith verify`` print for people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from gaitsmith.cli.dispatch import Table, Text

if TYPE_CHECKING:
    from gaitsmith.robots import Robot

_ROWS = 12
_WORST = {"constraint": "", "value": ".4g", "limit": ".4g", "unit": "", "time": ".3f", "phase": "", "violation": "+.3%"}


def plan_lines(document: dict[str, Any], robot: Robot) -> Iterator[Text]:
    """The result of a plan."""
    verified = ", verified" if document["verified"] else ""
    yield f"{document['motion']} for {robot.card.name}: {document['status']}{verified}"
    if document["without_solution"]:
        tried = ", ".join(f"{period:.3g}" for period in document["without_solution"])
        step = document["step"]
        planned = f"; planned with {step['period']:.3g} s, {step['length']:.3g} m" if step else ""
        yield f"no gait with steps of {tried} s at this speed{planned}"
    counted = ("iterations", "refinements", "fallbacks", "variables", "constraints")
    counts = ", ".join(f"{document[name]} {name}" for name in counted)
    times = ", ".join(f"{name} {document['time_s'][name]:.2f} s" for name in ("setup", "compile", "solve", "check"))
    yield f"objective {figure(document['objective'], '.4g')}, {counts}; {times}"
    if not document["symmetric"]:
        yield f"left and right differ by {document['asymmetry']:.2%}: a stride of two steps, without the mirror"
    if document["held"]:
        yield f"held at home: {', '.join(document['held'])}"
    if document["free_durations"]:
        yield "durations chosen: " + ", ".join(f"{name} {t:.3f} s" for name, t in document["free_durations"].items())
    if document["max_torque"] is not None:
        margin, jump = figure(document["zmp_margin_mm"], ".1f"), figure(document["torque_jump"], ".2g")
        yield f"smallest ZMP margin in single support {margin} mm, largest jump of a torque {jump} N·m"
        torques = zip(document["max_torque"].items(), robot.torque_limit, strict=True)
        rows = [(name, f"{value:.2f}", f"{limit:g}") for (name, value), limit in torques]
        yield Table(("joint", "peak torque\nN·m", "limit\nN·m"), rows)
    yield from _worst(document["worst"])
    yield from (f"warning: {warning}" for warning in document["warnings"])
    yield from (f"written: {path}" for path in (document["file"], *document.get("figures", [])) if path)


def verdict_lines(document: dict[str, Any]) -> Iterator[Text]:
    """What ``gaitsmith verify`` found."""
    yield "ok: file and physics agree" if document["ok"] else "not ok"
    yield from (f"  {problem}" for problem in document["problems"])
    closure, seam = document["closure"], document["seam"]
    yield (
        f"closure {closure['position_mm']:.2g} mm, {closure['velocity']:.2g} m/s, {closure['acceleration']:.2g} m/s²; "
        f"torque jump {document['torque_jump']:.2g} N·m; residual {document['dynamics_residual']:.2g} of the weight"
    )
    yield (
        f"penetration {document['penetration_mm']:.3g} mm; clearance at mid-swing "
        f"{figure(document['clearance_mm'], '.3g')} mm; ZMP margin {figure(document['zmp_margin_mm'], '.1f')} mm; "
        f"base jumps {seam['position_m']:.1g} m where the support changes"
    )
    yield f"checked {document['checked']} bounds, conditions and entries of the certificate"
    yield from _worst(document["worst"])
    if document["rigorous"] is not None:
        yield from _proof(document["rigorous"])


def _proof(proof: dict[str, Any]) -> Iterator[Text]:
    """What is proved for all times."""
    yield "proved for all times: every bound holds" if proof["ok"] else "not proved for all times"
    headings = ("constraint", "least", "largest", "limit", "unit", "time\ns", "phase")
    rows = []
    for item in proof["worst"][:_ROWS]:
        numbers = (*item["range"], item["limit"])
        shown = [figure(value, ".7g") for value in numbers]
        rows.append([item["constraint"], *shown, item["unit"], f"{item['time']:.4f}", item["phase"]])
    yield Table(headings, rows, left=(0, 4, 6), title="closest to their limits at any time")
    box = proof["box"]
    if box is None:
        return
    friction = "as planned" if box["friction"] is None else f"{box['friction'][0]:g} to {box['friction'][1]:g}"
    yield f"masses ±{box['mass']:.1%}, friction {friction}, footholds ±{1e3 * box['foothold']:g} mm:"
    for item in box["constraints"]:
        told = f"holds for all of the box, at least {figure(item['margin'], '.4g')} {item['unit']} inside"
        if item["unproved"]:
            spans = ", ".join(f"{s['from']:.3f} to {s['to']:.3f} s ({s['phase']})" for s in item["unproved"][:_ROWS])
            told = f"not proved from {spans}"
        yield f"  {item['constraint']}: {told}"


def _worst(worst: list[dict[str, Any]]) -> Iterator[Table]:
    """The constraints closest to their limits, if any were looked at."""
    if worst:
        headings = ("constraint", "worst", "limit", "unit", "time\ns", "phase", "beyond\n% of range")
        rows = [[format(item[name], form).rstrip("%") for name, form in _WORST.items()] for item in worst[:_ROWS]]
        yield Table(headings, rows, left=(0, 3, 5), title="closest to their limits")


def figure(value: float | None, form: str) -> str:
    """A number as :func:`format` writes it, or a dash for one that does not exist."""
    return "-" if value is None or not math.isfinite(value) else format(value, form)
