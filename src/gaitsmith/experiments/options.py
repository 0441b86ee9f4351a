"""What can be asked of the experiments; the fields are the options of ``gaitsmith bench``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from gaitsmith.documents import About, Frozen

RobotName = Annotated[str, About("A robot of the package, or the path of a card", metavar="NAME_OR_PATH")]
Preset = Annotated[str, About("Control parameters of the card", metavar="NAME")]
Jobs = Annotated[int, Field(ge=1, le=256), About("Processes", metavar="N")]
Where = Annotated[Literal["local", "ray"], About("Where it runs: processes of this machine, or a Ray cluster")]
Address = Annotated[str | None, About("Of the Ray cluster's head", metavar="HOST:PORT", absent="none")]
_Set = Annotated[
    str | None,
    About(
        "Set of trials and grids of the package, or a TOML file",
        metavar="NAME_OR_FILE",
        absent="planned with a gait, else walks",
    ),
]
_Robot = Annotated[
    str | None, About("A robot of the package, or the path of a card", metavar="NAME_OR_PATH", absent="the set's")
]
_Gait = Annotated[str | None, About("A planned gait to walk", metavar="FILE", absent="the template")]
_Engine = Annotated[Literal["mujoco", "bullet"], About("Physics: MuJoCo, or Bullet (extra bullet)")]
_Folder = Annotated[str, About("Folder of results; runs found there are not repeated", metavar="DIR")]


class TickOptions(Frozen):
    """Measure one control tick: template, inverse kinematics, whole-body QP and joint torques."""

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    duration: Annotated[float, Field(ge=5.0, le=600.0), About("Simulated time that is measured", "s", "S")] = 20.0


class PushOptions(Frozen):
    """Push the walking robot in every direction at every phase of the stride.

    Without a walk or an impulse of its own it runs the grids of a set; with one of them it runs that single grid.
    """

    set: _Set = None
    robot: _Robot = None
    preset: Preset = "default"
    gait: _Gait = None
    engine: _Engine = "mujoco"
    impulse: Annotated[
        float | None, About("Impulse of 0.1 s at the torso's centre of mass", "N·s", "N·s", absent="standard")
    ] = None
    strength: Annotated[
        float | None, About("The impulse over mass times √(gH) instead", metavar="X", absent="standard")
    ] = None
    speed: Annotated[
        tuple[float, float] | None, About("Forward and lateral speed", "m/s", "VX [VY]", absent="standard")
    ] = None
    height: Annotated[float | None, About("Hip midpoint above the stance sole", "m", "M", absent="standard")] = None
    period: Annotated[float | None, About("Duration of one step", "s", "S", absent="standard")] = None
    directions: Annotated[
        int | None,
        Field(ge=1, le=360),
        About("Directions, evenly around the robot", metavar="N", absent="the set's, or 8"),
    ] = None
    phases: Annotated[
        int | None, Field(ge=1, le=360), About("Phases, evenly over one stride", metavar="N", absent="the set's, or 12")
    ] = None
    largest: Annotated[bool, About("Search the largest impulse survived in every direction instead")] = False
    jobs: Jobs = 1
    out: _Folder = "runs/bench"


class BatteryOptions(Frozen):
    """Run the trials of a set: speeds, heights, slopes, boxes, noise, each against its target."""

    set: _Set = None
    robot: _Robot = None
    preset: Preset = "default"
    gait: _Gait = None
    engine: _Engine = "mujoco"
    only: Annotated[tuple[str, ...], About("Run these trials only", metavar="NAME")] = ()
    jobs: Jobs = 1
    out: _Folder = "runs/bench"


class FaultOptions(Frozen):
    """Let every sensor, every motor and the ticks fail in every way, for 10, 100 and 1000 ms, while the robot walks.

    A fault begins at four instants of a stride. Some may be named; otherwise all are run.
    """

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    state: Annotated[
        Literal["true", "estimated"], About("What the controller sees: the true state, or noisy sensors")
    ] = "true"
    component: Annotated[tuple[str, ...], About("Let only these fail", metavar="NAME")] = ()
    type: Annotated[tuple[str, ...], About("Only in these ways", metavar="TYPE")] = ()
    duration: Annotated[
        tuple[Annotated[float, Field(gt=0.0, le=60.0)], ...],
        About("How long", "s", "S", absent="0.01, 0.1 and 1"),
    ] = (0.01, 0.1, 1.0)
    instants: Annotated[int, Field(ge=1, le=64), About("Instants, evenly over a stride", metavar="N")] = 4
    speed: Annotated[float, About("Forward speed", "√(gH)", "X")] = 0.115
    jobs: Jobs = 1
    out: _Folder = "runs/bench"


class FallOptions(Frozen):
    """Draw falls of known cause, one factor each, and see whether the fall report names it and a replay confirms it."""

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    falls: Annotated[int, Field(ge=1, le=10_000), About("Falls", metavar="N")] = 100
    kind: Annotated[tuple[str, ...], About("Only of these causes", metavar="NAME")] = ()
    seed: Annotated[int, Field(ge=0, lt=2**32), About("Seed of what is drawn", metavar="N")] = 0
    out: _Folder = "runs/bench"


class CrashOptions(Frozen):
    """Find out what fells a controller: pushes, random walks, faults, ground; one sheet that anybody can make again.

    Sizes are shares of the robot's mass, height and gravity, so that robots can be compared. Parts may be named;
    otherwise all are run.
    """

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    controller: Annotated[
        str,
        About(
            "What walks: the package's own controller, that with a policy, or one in another process",
            metavar="ours|onnx:FILE|socket:PORT",
        ),
    ] = "ours"
    only: Annotated[
        tuple[Literal["pushes", "weakest", "episodes", "faults", "terrain"], ...],
        About("Run these parts only", metavar="PART"),
    ] = ()
    runs: Annotated[int, Field(ge=1, le=1_000_000), About("Random walks at most", metavar="N")] = 100
    target: Annotated[
        float | None,
        Field(gt=0.0, lt=1.0),
        About("Stop the random walks once the share that stands is surely above or below it", metavar="SHARE"),
    ] = None
    seed: Annotated[int, Field(ge=0, lt=2**31), About("Of the first random walk", metavar="N")] = 0
    strength: Annotated[
        float, Field(gt=0.0, le=2.0), About("Impulse of a push of 0.1 s over mass times √(gH)", metavar="X")
    ] = 0.15
    directions: Annotated[int, Field(ge=1, le=360), About("Directions of pushes", metavar="N")] = 8
    phases: Annotated[int, Field(ge=1, le=360), About("Phases of the stride at which they begin", metavar="N")] = 12
    instants: Annotated[int, Field(ge=1, le=64), About("Instants of a stride at which faults begin", metavar="N")] = 1
    duration: Annotated[
        tuple[Annotated[float, Field(gt=0.0, le=60.0)], ...], About("How long faults last", "s", "S", absent="0.1")
    ] = (0.1,)
    tour: Annotated[int, Field(ge=0, le=10_000), About("Run ids of the public teleoperation test too", metavar="N")] = 0
    jobs: Jobs = 1
    engine: Where = "local"
    address: Address = None
    out: _Folder = "runs/crash"


class TourOptions(Frozen):
    """Run the public teleoperation test of walking: 90 s, 18 waypoints, 18 punches.

    The table has our row beside published ones, and says what is different.
    """

    robot: RobotName = "bhr_b2"
    preset: Preset = "default"
    runs: Annotated[int, Field(ge=1, le=10_000), About("Run ids", metavar="N")] = 32
    first: Annotated[int, Field(ge=0, lt=2**31), About("The first of them", metavar="ID")] = 0
    force: Annotated[float, Field(ge=0.0, le=10.0), About("Factor on all punches, 0 for none", metavar="X")] = 1.0
    height: Annotated[float | None, About("Hip midpoint above the stance sole", "m", "M", absent="legs bent")] = None
    period: Annotated[float | None, About("Duration of one step", "s", "S", absent="by the height")] = None
    width: Annotated[float | None, About("Half the distance of the soles", "m", "M", absent="wide")] = None
    jobs: Jobs = 1
    out: _Folder = "runs/bench"
