"""``gaitsmith library``: a grid of gaits planned into a folder, and what such a folder holds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gaitsmith.cli.arguments import Arguments, Positional, parse
from gaitsmith.cli.dispatch import DONE, INTERRUPTED, NOT_SOLVED, Outcome, Table, Text
from gaitsmith.documents import About
from gaitsmith.errors import BadInput
from gaitsmith.experiments.options import Address, Jobs, Where
from gaitsmith.work.workers import address_of

if TYPE_CHECKING:
    from gaitsmith.library.folder import Record
    from gaitsmith.library.spec import Spec


class BuildArguments(Arguments):
    """Plan a grid of cyclic gaits, and the start and stop of the slowest one, into a folder.

    Killed at any moment, the same command goes on: a gait that is done stays as it is.
    """

    spec: Annotated[
        str, Positional("Grid: robot, speed, step_height, period, yaw_rate, slope, settings (TOML)", metavar="SPEC")
    ]
    out: Annotated[str, About("Folder of the library", metavar="DIR")]
    jobs: Jobs = 1
    engine: Where = "local"
    address: Address = None


class ShowArguments(Arguments):
    """What a library holds: a table, and a picture of its grid."""

    library: Annotated[str, Positional("Folder of a library", metavar="DIR")]
    figure: Annotated[
        str | None, About("Picture of the grid, PNG, with SVG beside it", metavar="FILE.png", absent="none")
    ] = None


def build(words: list[str], program: str) -> Outcome:
    """Run ``library build``."""
    arguments = parse(BuildArguments, words, program)
    address = address_of(arguments.engine, arguments.address)
    from gaitsmith.cli.display import Display
    from gaitsmith.library.building import build as run
    from gaitsmith.library.building import failures
    from gaitsmith.library.folder import Folder
    from gaitsmith.library.spec import read_spec

    spec = read_spec(arguments.spec)
    with Display() as display:
        built = run(
            spec,
            Folder(arguments.out),
            jobs=arguments.jobs,
            address=address,
            tell=lambda done, total: display.show("planning", f"{done} of {total}", done, total),
            notify=display.slow,
        )
    failed = failures(built)
    points = {key: record for key, record in built.records.items() if not key.startswith(("start", "stop"))}
    certified = sum(record.certified for record in points.values())
    document = {
        "library": arguments.out,
        "gaits": len(spec.points),
        "certified": certified,
        "failed": failed,
        "base": built.base or None,
        "seconds": built.seconds,
        "resumed": built.resumed,
        "interrupted": built.interrupted,
    }
    text: list[Text] = [f"{certified} of {len(spec.points)} gaits certified, in {arguments.out}"]
    text += [f"{item['point']}: {item['reason']}" for item in failed]
    if built.resumed:
        text.append(f"{built.resumed} of them were there already")
    if built.interrupted:
        text.append("interrupted; the same command goes on from there")
    elif built.base:
        text.append(f"gaitsmith walk --library {arguments.out} --speed {spec.place(spec.points[-1])['speed']:g}")
    else:
        text.append("no start and stop could be planned: this library cannot be walked from rest")
    code = INTERRUPTED if built.interrupted else DONE if not failed else NOT_SOLVED
    return Outcome(code, document, text)


def show(words: list[str], program: str) -> Outcome:
    """Run ``library show``."""
    arguments = parse(ShowArguments, words, program)
    from gaitsmith.library.folder import Folder

    folder = Folder(arguments.library)
    spec, _ = folder.spec()
    records = folder.records()
    figures = _draw(arguments.figure, spec, records) if arguments.figure is not None else []
    certified = sum(record.certified for record in records.values())
    points = [_point(spec, key, record) for key, record in records.items()]
    document = {
        "library": arguments.library,
        "robot": spec.robot,
        "axes": {name: list(axis) for name, axis in _axes(spec).items()},
        "gaits": len(spec.points),
        "planned": len(records),
        "certified": certified,
        "finished": (folder.path / "index.json").is_file(),
        "points": points,
        "figures": figures,
    }
    return Outcome(DONE, document, _lines(spec, records, document))


def _axes(spec: Spec) -> dict[str, tuple[float, ...]]:
    return dict(zip(spec.names, spec.axes, strict=True))


def _point(spec: Spec, key: str, record: Record) -> dict[str, Any]:
    from gaitsmith.library.spec import point_of

    shown = record.model_dump(mode="json", include={"status", "reason", "objective", "iterations", "origin"})
    return {"point": key, **spec.place(point_of(key)), **shown}


def _lines(spec: Spec, records: dict[str, Record], document: dict[str, Any]) -> Iterator[Text]:
    from gaitsmith.library.spec import AXES

    yield f"{spec.robot}: {document['certified']} of {document['gaits']} gaits certified, {len(records)} planned"
    names = list(_axes(spec))
    rows = []
    for item in document["points"]:
        numbers = [f"{item[name]:g}" for name in names]
        rows.append([*numbers, item["status"], f"{item['objective']:.1f}", f"{item['iterations']}", item["reason"]])
    headings = [f"{name.replace('_', ' ')}\n{AXES[name]}" for name in names]
    yield Table((*headings, "status", "objective", "iterations", "reason"), rows, (len(names), len(names) + 3))
    if not document["finished"]:
        yield "not finished: the command that built it goes on where it stopped"
    yield from document["figures"]


def _draw(path: str, spec: Spec, records: dict[str, Record]) -> list[str]:
    from gaitsmith.simulation.run_folder import check_file
    from gaitsmith.view.canvas import save
    from gaitsmith.view.library_map import draw_library

    if Path(path).suffix != ".png":
        raise BadInput("--figure", path, "a file that ends in .png")
    try:
        target = check_file(path)
    except BadInput as error:
        raise BadInput("--figure", error.value, error.valid, error.remedy) from None
    return [str(save(draw_library(spec, records), target))]
