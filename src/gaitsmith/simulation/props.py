"""What lies in the world beside the robot and the ground: balls."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

_SOLREF = (0.005, 1.0)  # s, -: as stiff as the ground
_FRICTION = (0.6, 0.005, 0.0001)  # against what takes no priority


@dataclass(frozen=True)
class Ball:
    """A ball at rest.

    Attributes:
        position: of its centre, world, m.
        radius: m.
        mass: kg.
    """

    position: tuple[float, float, float]
    radius: float = 0.05
    mass: float = 0.2

    def add_to(self, spec: mujoco.MjSpec, name: str) -> None:
        """Add it behind the robot's bodies."""
        body = spec.worldbody.add_body(name=name, pos=self.position)
        body.add_freejoint(name=name)
        body.mass, body.explicitinertial = self.mass, True
        body.ipos, body.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        body.inertia = [0.4 * self.mass * self.radius**2] * 3
        shape = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[self.radius, 0.0, 0.0])
        shape.contype, shape.conaffinity = 1, 0x7FFFFFFF
        shape.friction, shape.solref = list(_FRICTION), list(_SOLREF)


class BallState:
    """A ball as it moves; SI units, world axes.

    Args:
        position: (3,) view of its centre.
        velocity: (3,) view.

    Attributes:
        top_speed: largest so far, m/s.
    """

    def __init__(self, position: npt.NDArray[np.float64], velocity: npt.NDArray[np.float64]) -> None:
        self.position, self.velocity = position, velocity
        self.restart()

    def restart(self) -> None:
        """Count from here."""
        self._start = self.position.copy()
        self.top_speed = 0.0

    def watch(self) -> None:
        """Take note of its speed now."""
        self.top_speed = max(self.top_speed, float(np.linalg.norm(self.velocity)))

    @property
    def travel(self) -> float:
        """Distance from where it was at first, m."""
        return float(np.linalg.norm(self.position - self._start))
