"""What makes two episodes the same: code, versions, robot, and scenario."""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import version

from gaitsmith.compiled.cache import source_key
from gaitsmith.files import read_bounded
from gaitsmith.robots import Robot
from gaitsmith.simulation.scenario import Scenario

_LOOP = "gaitsmith.simulation.episode"
_LARGEST_GAIT = 100_000_000  # bytes


def loop_identity(robot: Robot) -> str:
    """Hash of the closed loop's source and versions, and of the robot's files with all their presets."""
    parts = (source_key(_LOOP), version("mujoco"), robot.content_hash)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]


def episode_key(loop: str, scenario: Scenario) -> str:
    """Key of one episode.

    Args:
        loop: from :func:`loop_identity`.
        scenario: the robot's and the gait's names or paths do not count, their contents do.
    """
    fields = scenario.model_dump(mode="json", exclude={"robot"})
    if gait := fields.get("gait"):
        fields["gait"] = hashlib.sha256(read_bounded(gait, _LARGEST_GAIT)).hexdigest()
    text = json.dumps(fields, sort_keys=True, allow_nan=False)
    return hashlib.sha256(f"{loop}\n{text}".encode()).hexdigest()[:32]
