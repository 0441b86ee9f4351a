"""What ``gaitsmith plan`` and ``gaitsmith verify`` print for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsmith.robots import Robot

_ROWS = 12


def print_plan(document: dict[str, Any], robot: Robot) -> None:
    """The result of a plan as tables."""
    from gaitsmith.cli.printing import Printer, figure, table

    console = Printer()
    times = document["time_s"]
    console.print(f"{document['motion']} for {robot.card.name}: {document['status']}")
    counted = ("iterations", "refinements", "fallbacks", "variables", "constraints")
    clocks = ("setup", "compile", "solve", "check")
    console.print(
        f"objective {figure(document['objective'], '.4g')}, "
        + ", ".join(f"{document[name]} {name}" for name in counted)
        + "; "
        + ", ".join(f"{name} {times[name]:.2f} s" for name in clocks)
    )
    if document["max_torque"] is not None:
        margin, jump = figure(document["zmp_margin_mm"], ".1f"), figure(document["torque_jump"], ".2g")
        console.print(f"smallest ZMP margin in single support {margin} mm, largest jump of a torque {jump} N·m")
        torques = zip(document["max_torque"].items(), robot.torque_limit, strict=True)
        rows = [(name, f"{value:.2f}", f"{limit:g}") for (name, value), limit in torques]
        console.print(table(("joint", "peak torque\nN·m", "limit\nN·m"), rows))
    print_worst(console, document["worst"])
    for warning in document["warnings"]:
        console.print(f"warning: {warning}", soft_wrap=True)
    if document["file"]:
        console.print(f"written: {document['file']}", soft_wrap=True)
    for path in document.get("figures", []):
        console.print(f"written: {path}", soft_wrap=True)


def print_worst(console: Any, worst: list[dict[str, Any]]) -> None:
    """The constraints closest to their limits, if any were looked at."""
    if not worst:
        return
    from gaitsmith.cli.printing import table

    headings = ("constraint", "worst", "limit", "unit", "time\ns", "phase", "beyond\n% of range")
    rows = [
        (
            *(item["constraint"], f"{item['value']:.4g}", f"{item['limit']:.4g}", item["unit"]),
            *(f"{item['time']:.3f}", item["phase"], f"{100.0 * item['violation']:+.3f}"),
        )
        for item in worst[:_ROWS]
    ]
    console.print(table(headings, rows, left=(0, 3, 5), title="closest to their limits"))


def print_verdict(document: dict[str, Any]) -> None:
    """What ``gaitsmith verify`` found."""
    from gaitsmith.cli.printing import Printer, figure

    console = Printer()
    console.print("ok: file and physics agree" if document["ok"] else "not ok")
    for problem in document["problems"]:
        console.print(f"  {problem}")
    closure, seam = document["closure"], document["seam"]
    console.print(
        f"closure {closure['position_mm']:.2g} mm, {closure['velocity']:.2g} m/s, {closure['acceleration']:.2g} m/s²; "
        f"torque jump {document['torque_jump']:.2g} N·m; residual {document['dynamics_residual']:.2g} of the weight"
    )
    console.print(
        f"penetration {document['penetration_mm']:.3g} mm; clearance at mid-swing "
        f"{figure(document['clearance_mm'], '.3g')} mm; ZMP margin {figure(document['zmp_margin_mm'], '.1f')} mm; "
        f"base jumps {seam['position_m']:.1g} m where the support changes"
    )
    print_worst(console, document["worst"])
