"""What ``gaitsmith plan`` and ``gaitsmith verify`` print for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsmith.robots import Robot

_ROWS = 12


def print_plan(document: dict[str, Any], robot: Robot) -> None:
    """The result of a plan as tables."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from gaitsmith.cli.printing import Printer, figure

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
        table = Table(box=SIMPLE_HEAD)
        for heading in ("joint", "peak torque\nN·m", "limit\nN·m"):
            table.add_column(heading, justify="left" if heading == "joint" else "right")
        for (name, value), limit in zip(document["max_torque"].items(), robot.torque_limit, strict=True):
            table.add_row(name, f"{value:.2f}", f"{limit:g}")
        console.print(table)
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
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, title="closest to their limits", title_justify="left")
    for heading in ("constraint", "worst", "limit", "unit", "time\ns", "phase", "beyond\n% of range"):
        table.add_column(heading, justify="left" if heading in ("constraint", "unit", "phase") else "right")
    for item in worst[:_ROWS]:
        beyond = 100.0 * item["violation"]
        table.add_row(
            item["constraint"],
            f"{item['value']:.4g}",
            f"{item['limit']:.4g}",
            item["unit"],
            f"{item['time']:.3f}",
            item["phase"],
            f"{beyond:+.3f}",
        )
    console.print(table)


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
