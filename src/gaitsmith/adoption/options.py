"""What can be asked of an adoption and of a tuning; the fields are options of ``gaitsmith adopt`` and ``tune``."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gaitsmith.documents import About, Frozen
from gaitsmith.experiments.options import Address, Jobs, Preset, RobotName, Where

_Metres = Annotated[float, Field(gt=0.0, le=2.0)]


class AdoptOptions(Frozen):
    """How to adopt ``model``, a file or a name."""

    model: str
    out: Annotated[str | None, About("Folder to write", metavar="DIR", absent="one named after the robot")] = None
    name: Annotated[str, About("Name of the robot", metavar="NAME", absent="the model file's")] = ""
    feet: Annotated[
        tuple[str, ...], Field(max_length=2), About("Body of a foot, given for both if not inferred", metavar="BODY")
    ] = ()
    torso: Annotated[str, About("Body where the legs meet, if not inferred", metavar="BODY")] = ""
    sole: Annotated[
        tuple[_Metres, _Metres, _Metres, _Metres] | None,
        About(
            "Soles of feet without shapes, from the ankle: heel, toe, half width, and depth below it",
            "m",
            "HEEL TOE HALF_WIDTH DEPTH",
            absent="inferred",
        ),
    ] = None
    search: Annotated[
        int, Field(ge=0, le=10_000), About("Gaits and gains to try at most if it does not walk", metavar="N")
    ] = 40
    seed: Annotated[int, Field(ge=0, lt=2**32), About("Seed of the search", metavar="N")] = 0
    no_sheet: Annotated[bool, About("Do not measure speeds, heights, periods and pushes")] = False
    jobs: Jobs = 1


class TuneOptions(Frozen):
    """Which gains to tune, and how long to search."""

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    candidates: Annotated[int, Field(ge=1, le=100_000), About("Sets of gains that are tried", metavar="N")] = 40
    runs: Annotated[int, Field(ge=4, le=10_000), About("Walks of each", metavar="N")] = 32
    held_out: Annotated[int, Field(ge=4, le=10_000), About("Walks that the best is judged by", metavar="N")] = 64
    seed: Annotated[int, Field(ge=0, lt=2**31), About("Seed of the candidates and the walks", metavar="N")] = 0
    jobs: Jobs = 1
    engine: Where = "local"
    address: Address = None
    out: Annotated[str, About("Folder of results; walks found there are not repeated", metavar="DIR")] = "runs/tune"
