"""Pictures of a robot without a display: MuJoCo's own renderer, by software where there is no graphics card."""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import GaitsmithError
from gaitsmith.robots import Robot
from gaitsmith.simulation.props import Ball
from gaitsmith.simulation.terrain import Region, Terrain
from gaitsmith.simulation.world import add_ground, set_options

Array = npt.NDArray[np.float64]
_PLATFORMS = ("egl", "osmesa")
_SKY, _FLOOR, _GRID = (0.93, 0.95, 0.97), (0.80, 0.83, 0.86), (0.70, 0.74, 0.78)
_BALL = (0.96, 0.47, 0.16, 1.0)
_TURN, _LOOK_DOWN, _AWAY = 125.0, -10.0, 3.3  # degrees, degrees, heights of the robot


class NoRenderer(GaitsmithError):
    """This machine offers no way to draw without a display."""


class Renderer:
    """Draws a robot at any state; to be closed.

    Args:
        size: width and height, pixels.

    Raises:
        NoRenderer: neither EGL nor OSMesa can be had.
    """

    def __init__(
        self,
        robot: Robot,
        size: tuple[int, int] = (640, 360),
        terrain: Terrain | None = None,
        region: Region | None = None,
        ball: Ball | None = None,
    ) -> None:
        self.width, self.height = size
        self._context = _context(*size)
        spec = robot.make_spec()
        set_options(spec, 1e-3)
        add_ground(spec, terrain or Terrain(), region or Region(), 0.8)
        if ball is not None:
            ball.add_to(spec, "ball_1")
            spec.geom("ball_1").rgba = _BALL
        _dress(spec, *size)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._nq, self._torso = robot.model.nq, robot.torso_body
        self._scene, self._option = mujoco.MjvScene(self._model, 2000), mujoco.MjvOption()
        self._drawing = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        self._camera = mujoco.MjvCamera()
        self._camera.azimuth, self._camera.elevation = _TURN, _LOOK_DOWN
        self._tall = float(robot.card.gait.height)
        self._camera.distance = _AWAY * self._tall

    def draw(self, position: Array, ball: Array | None = None) -> npt.NDArray[np.uint8]:
        """(height, width, 3) colours of the robot at a position (nq,); the camera goes with it."""
        self._data.qpos[: self._nq] = position
        if ball is not None:
            self._data.qpos[self._nq : self._nq + 3] = ball
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        self._camera.lookat[:] = (*self._data.xpos[self._torso][:2], 0.8 * self._tall)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, self._data, self._option, None, self._camera, everything, self._scene)
        frame = mujoco.MjrRect(0, 0, self.width, self.height)
        mujoco.mjr_render(frame, self._scene, self._drawing)
        picture = np.empty((self.height, self.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(picture, None, frame, self._drawing)
        return picture[::-1]

    def close(self) -> None:
        """Give back what the graphics library holds."""
        self._drawing.free()
        self._context.free()


def _context(width: int, height: int) -> Any:
    """A place to draw to, by the first library that works."""
    told = []
    for platform in _PLATFORMS:
        before = os.environ.get("PYOPENGL_PLATFORM")
        try:
            context = import_module(f"mujoco.{platform}").GLContext(width, height)
            context.make_current()
            return context
        except Exception as error:  # what a missing library raises differs from one to the next
            told.append(f"{platform}: {str(error) or type(error).__name__}".split("\n")[0][:120])
            if before is None:
                os.environ.pop("PYOPENGL_PLATFORM", None)
    raise NoRenderer(f"no renderer without a display ({'; '.join(told)}); install libegl1 or libosmesa6")


def _dress(spec: Any, width: int, height: int) -> None:
    """Light, sky and a floor whose squares of half a metre show how far one walks."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = (0.45,) * 3, (0.4,) * 3
    spec.visual.map.znear = 0.02
    spec.visual.quality.shadowsize = 0
    sky = {"type": mujoco.mjtTexture.mjTEXTURE_SKYBOX, "builtin": mujoco.mjtBuiltin.mjBUILTIN_GRADIENT}
    spec.add_texture(name="gaitsmith_sky", width=64, height=64, rgb1=_SKY, rgb2=(1.0, 1.0, 1.0), **sky)
    floor = {"type": mujoco.mjtTexture.mjTEXTURE_2D, "builtin": mujoco.mjtBuiltin.mjBUILTIN_CHECKER}
    spec.add_texture(name="gaitsmith_floor", width=128, height=128, rgb1=_FLOOR, rgb2=_GRID, **floor)
    textures = [""] * int(mujoco.mjtTextureRole.mjNTEXROLE)
    textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = "gaitsmith_floor"
    spec.add_material(name="gaitsmith_floor", textures=textures, texrepeat=(1.0, 1.0), texuniform=True)
    for geom in spec.worldbody.geoms:
        geom.material = "gaitsmith_floor"
    spec.worldbody.add_light(
        pos=(0.0, 0.0, 6.0), dir=(0.2, 0.3, -1.0), type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, castshadow=False
    )
