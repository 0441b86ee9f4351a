"""A run as a film: the robot as its log tells of it, in real time."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.files import regular_target
from gaitsmith.reports.rendering import Renderer
from gaitsmith.reports.run import Run
from gaitsmith.simulation.scene_log import positions
from gaitsmith.simulation.terrain import parse_terrain

Array = npt.NDArray[np.float64]
CODEC = "vp09"
"""VP9 in an MP4: free of licences, and every browser plays it."""
_RATE = 25.0  # pictures a second


def need_video() -> None:
    """Refuse early where the library that writes films is absent.

    Raises:
        GaitsmithError: it is.
    """
    try:
        import_module("cv2")
    except ImportError:
        raise GaitsmithError("a video needs OpenCV: pip install 'gaitsmith[video]'") from None


def write_video(run: Run, path: Path, speed: float, tell: Callable[[int, int], None] = lambda done, total: None) -> int:
    """Write a run as MP4; the file appears whole or not at all. Returns the number of pictures.

    Args:
        speed: 1 is real time, 0.25 slow motion.
        tell: hears of pictures done and of all.

    Raises:
        BadInput: the file cannot be written.
        GaitsmithError: no OpenCV, or no renderer.
    """
    need_video()
    import cv2

    log, target = run.log, regular_target(path)
    times = np.arange(float(log.time[0]), float(log.time[-1]), speed / _RATE)
    where = positions(log, run.robot)[np.searchsorted(log.time, times)]
    terrain = parse_terrain(run.scenario.terrain, run.scenario.seed)
    renderer = Renderer(run.robot, terrain=terrain, region=run.scenario.region())
    temporary = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(6)}.mp4")
    try:
        size = (renderer.width, renderer.height)
        writer = cv2.VideoWriter(str(temporary), cv2.VideoWriter.fourcc(*CODEC), _RATE, size)
        if not writer.isOpened():
            raise BadInput("--out", str(path), "a file in a folder that can be written, with a codec that is there")
        for number, (time, position) in enumerate(zip(times, where, strict=True)):
            picture = np.ascontiguousarray(renderer.draw(position)[:, :, ::-1])
            _caption(picture, run, float(time), speed)
            writer.write(picture)
            tell(number + 1, len(times))
        writer.release()
        temporary.replace(target)
    finally:
        renderer.close()
        temporary.unlink(missing_ok=True)
    return len(times)


def _caption(picture: npt.NDArray[np.uint8], run: Run, time: float, speed: float) -> None:
    """Time, command, and what is happening, written on the picture."""
    import cv2

    row = min(int(np.searchsorted(run.log.time, time)), len(run.log.time) - 1)
    now = {name: float(run.log.column(name)[row]) for name in ("command.speed_x", "command.speed_y")}
    slow = "" if speed == 1.0 else f"  x{speed:g}"
    line = f"{run.summary.robot}  t {time:5.2f} s{slow}  command {now['command.speed_x']:+.2f} m/s"
    cv2.putText(picture, line, (16, 30), cv2.FONT_HERSHEY_SIMPLEX, 0.65, (40, 30, 30), 1, cv2.LINE_AA)
    fall = run.summary.fall
    pushes = [push for push in run.recording.pushes if push.begin <= time <= push.end + 0.2]
    said = [f"push {push.words}".replace("·", " ") for push in pushes]
    said += ["fell"] if fall is not None and time >= fall.time - 0.05 else []
    if said:
        cv2.putText(picture, ", ".join(said), (16, 58), cv2.FONT_HERSHEY_SIMPLEX, 0.65, (30, 20, 190), 2, cv2.LINE_AA)
