"""The three-dimensional picture: robot and ground, and what is laid over them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import trimesh

from gaitsmith.live.frame import Frame
from gaitsmith.live.geometry import LEFT, RIGHT, meshes_of
from gaitsmith.live.pose import Pose
from gaitsmith.live.server import Server
from gaitsmith.robots import Robot
from gaitsmith.simulation.terrain import Region, parse_terrain

Array = npt.NDArray[np.float64]

OVERLAYS = {
    "support": "Support polygon",
    "zmp": "ZMP",
    "com": "Centre of mass",
    "planned": "Planned footholds",
    "steps": "Footprints",
    "forces": "Contact forces",
    "trails": "Foot trails",
    "push": "Pushes",
}
"""What can be laid over the picture, by name."""
SIDES = (LEFT, RIGHT)
_GREEN, _MAGENTA, _GOLD, _RED = (60, 175, 90), (200, 40, 160), (235, 175, 20), (214, 40, 40)
_ICE = (150, 205, 235)
_ON_PLANE = ("flat", "boxes", "stairs")  # grounds that lie on a level plane
_ABOVE = 0.003  # m by which flat marks lie over the ground
_LIFTED = np.array([0.0, 0.0, _ABOVE])
_SEE_THROUGH = 0.45
_STEPS = 24  # footprints that stay
_TRAIL = 1.5  # s of a foot's way that stay
_CLEAR = 0.3  # of the hips' height that a push's arrow ends before the torso's centre
_PUSH_SEEN = 0.5  # s for which a push stays to be seen


class Scene:
    """Robot, ground and overlays.

    Attributes:
        pose: of the robot as shown last.
        follow: whether the picture moves with the robot.
    """

    def __init__(self, server: Server, robot: Robot, balls: int) -> None:
        self._server, self._robot, self.pose = server, robot, Pose(robot)
        self.size = float(robot.card.gait.height)
        self._weight = robot.mass * float(np.linalg.norm(robot.model.opt.gravity))
        self.follow = True
        scene = server.scene
        scene.configure_default_lights(enabled=False, cast_shadow=False)
        scene.configure_environment_map(None)
        scene.add_light_hemisphere(
            "/lights/sky", sky_color=(255, 255, 255), ground_color=(190, 195, 205), intensity=2.4
        )
        scene.add_light_directional(
            "/lights/sun", color=(255, 250, 240), intensity=1.9, cast_shadow=True, position=(3.0, -4.0, 6.0)
        )
        scene.set_background_image(_sky(), format="png")
        self._world = scene.add_frame("/world", show_axes=False)
        self._bodies = {b: scene.add_frame(f"/world/robot/{b}", show_axes=False) for b in range(1, robot.model.nbody)}
        self._torso: Any = None
        self._shapes: list[tuple[Any, float | None]] = []
        for k, mesh in enumerate(meshes_of(robot)):
            handle = scene.add_mesh_simple(
                f"/world/robot/{mesh.body}/shape_{k}",
                mesh.vertices.astype(np.float32),
                mesh.faces.astype(np.uint32),
                color=mesh.colour,
                opacity=None if mesh.opacity >= 1.0 else mesh.opacity,
                flat_shading=len(mesh.faces) <= 12,
                side="double",
                receive_shadow=False,
            )
            self._shapes.append((handle, handle.opacity))
            if mesh.body == robot.torso_body:
                self._torso = handle
        self._balls = [
            scene.add_icosphere(f"/world/ball_{k}", radius=0.05, color=(245, 120, 40), subdivisions=4)
            for k in range(balls)
        ]
        # What moves with the robot is drawn about it, not in the world: a slow browser shows it late, not elsewhere.
        self._groups = {name: scene.add_frame(f"/near/{name}", show_axes=False) for name in OVERLAYS if name != "steps"}
        self._groups["steps"] = scene.add_frame("/world/steps", show_axes=False)
        self._make_marks()
        self._place = np.zeros(2)
        self._episode, self._steps_taken, self._time = -1.0, -1.0, 0.0
        self._trail: deque[tuple[float, Array]] = deque(maxlen=256)
        self._prints: deque[tuple[int, Array]] = deque(maxlen=_STEPS)
        self._pushed = (-math.inf, np.zeros(3))
        self._steps_changed = False
        self.set_ground("flat", 0, Region())
        server.set_camera(self.size)

    def _make_marks(self) -> None:
        """Everything that lies over the picture, out of sight."""
        scene, size = self._server.scene, self.size
        corners = max(2 * len(leg.sole.corners) for leg in self._robot.legs)
        fan = np.array([(0, k, k + 1) for k in range(1, corners - 1)], dtype=np.uint32)
        self._support = scene.add_mesh_simple(
            "/near/support/area", np.zeros((corners, 3)), fan, color=_GREEN, opacity=0.35, side="double"
        )
        self._support_edge = self._lines("/near/support/edge", corners, _GREEN, 0.012 * size)
        self._com = scene.add_icosphere("/near/com/point", radius=0.04 * size, color=_GOLD, cast_shadow=False)
        disc = {"height": 0.004 * size, "cast_shadow": False}
        self._com_below = scene.add_cylinder("/near/com/below", radius=0.03 * size, color=_GOLD, **disc)
        self._zmp = scene.add_cylinder("/near/zmp/point", radius=0.045 * size, color=_MAGENTA, **disc)
        self._com_line = self._lines("/near/com/line", 1, _GOLD, 0.006 * size)
        self._planned = [
            self._lines(f"/near/planned/{leg.name}", len(leg.sole.corners), colour, 0.012 * size)
            for leg, colour in zip(self._robot.legs, SIDES, strict=True)
        ]
        self._printed = self._lines("/world/steps/outline", 1, (120, 120, 120), 0.007 * size)
        self._trails = [
            self._lines(f"/near/trails/{leg.name}", 1, colour, 0.006 * size)
            for leg, colour in zip(self._robot.legs, SIDES, strict=True)
        ]
        arrow = {"shaft_radius": 0.009 * size, "head_radius": 0.024 * size, "head_length": 0.05 * size}
        first = np.array([[(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]])
        self._forces = scene.add_arrows("/near/forces/arrows", first, (35, 150, 120), visible=False, **arrow)
        wide = {name: 1.8 * width for name, width in arrow.items()}
        self._push = scene.add_arrows("/near/push/arrow", first, _RED, visible=False, **wide)

    def _lines(self, name: str, count: int, colour: tuple[int, int, int], thickness: float) -> Any:
        """Line segments, out of sight."""
        points = np.zeros((max(count, 1), 2, 3), dtype=np.float32)
        return self._server.scene.add_line_segments(name, points, colour, thickness=thickness, visible=False)

    def on_drag(self, pull: Callable[[Array, bool], None]) -> None:
        """Hear of the torso being dragged: by how much, world axes, m, and whether it goes on."""
        if self._torso is None:
            return

        async def dragged(event: Any) -> None:
            pull(np.subtract(event.end_position, event.start_position), event.phase != "end")

        self._torso.on_drag("left")(dragged)

    def show_overlay(self, name: str, visible: bool) -> None:
        """Show or hide one of :data:`OVERLAYS`."""
        self._groups[name].visible = visible

    def see_through(self, on: bool) -> None:
        """Let the robot hide nothing, or look as it is."""
        for handle, opacity in self._shapes:
            handle.opacity = _SEE_THROUGH if on else opacity

    def set_ground(self, terrain: str, seed: int, region: Region) -> None:
        """Draw a terrain."""
        scene = self._server.scene
        ground = parse_terrain(terrain, seed)
        scene.add_grid(
            "/world/ground/grid",
            width=80.0,
            height=80.0,
            cell_size=0.1 if self.size < 0.5 else 0.25,
            section_size=1.0,
            cell_color=(205, 211, 219),
            section_color=(160, 169, 182),
            fade_distance=30.0 * max(self.size, 0.5),
            plane_color=(228, 232, 238),
            plane_opacity=1.0 if ground.kind in _ON_PLANE else 0.0,
            shadow_opacity=0.3,
            position=(0.0, 0.0, -0.001),
        )
        blocks = ground.blocks(region)
        old = scene.get_handle_by_name("/world/ground/blocks")
        if old is not None:
            old.remove()
        if not blocks:
            return
        box = trimesh.creation.box((1.0, 1.0, 1.0))
        tops = np.array([block.centre[2] + block.half_size[2] for block in blocks])
        shade = (tops / max(float(np.abs(tops).max()), 1e-9))[:, None] if ground.kind in _ON_PLANE else 0.0
        colours = np.clip(np.array([222, 226, 232]) - shade * np.array([70, 55, 35]), 0, 255)
        colours = np.broadcast_to(colours, (len(blocks), 3)).astype(np.uint8)
        colours[[block.friction is not None for block in blocks]] = _ICE
        scene.add_batched_meshes_simple(
            "/world/ground/blocks",
            box.vertices,
            box.faces,
            np.array([_turned(block.pitch, block.roll) for block in blocks]),
            np.array([b.centre for b in blocks]),
            batched_scales=np.array([2.0 * np.array(b.half_size) for b in blocks]),
            batched_colors=colours,
            lod="off",
            flat_shading=True,
            cast_shadow=False,
        )

    def show(self, frame: Frame, slow: bool) -> None:
        """Show a frame; ``slow`` also what need not be new every time."""
        pose = self.pose
        pose.take(frame)
        self._note(frame)
        with self._server.together():
            self._move(frame)
            self._mark(frame)
            if slow:
                self._draw_trails()
                if self._steps_changed:
                    self._draw_prints()

    def _note(self, frame: Frame) -> None:
        """Footprints, trails and pushes, as they come."""
        time = frame["live.time"]
        if frame["live.episode"] != self._episode or time < self._time - 1e-9:
            self._trail.clear()
            self._prints.clear()
            self._pushed, self._steps_changed, self._steps_taken = (-math.inf, np.zeros(3)), True, -1.0
        self._episode = frame["live.episode"]
        if time > self._time + 0.5 * _TRAIL:
            self._trail.clear()  # somebody has jumped ahead
        if time != self._time:
            self._trail.append((time, self.pose.sole_position.copy()))
        self._time = time
        if frame["step_count"] != self._steps_taken:
            row = int(frame["stance"])
            if row < len(self.pose.soles):
                self._prints.append((row, self.pose.soles[row].copy()))
                self._steps_changed = True
            self._steps_taken = frame["step_count"]
        if frame.push.any():
            self._pushed = (time, frame.push.copy())

    def _move(self, frame: Frame) -> None:
        """Bodies, balls, and the world under a robot that is followed."""
        pose = self.pose
        torso = pose.body_position[self._robot.torso_body]
        self._place = self._place + 0.15 * (torso[:2] - self._place) if self.follow else self._place
        if np.linalg.norm(torso[:2] - self._place) > self.size:
            self._place = torso[:2].copy() if self.follow else self._place
        self._world.position = (-self._place[0], -self._place[1], 0.0)
        for body, handle in self._bodies.items():
            handle.position, handle.wxyz = pose.body_position[body], pose.body_quaternion[body]
        for handle, place in zip(self._balls, frame.balls, strict=True):
            handle.position = place

    def _mark(self, frame: Frame) -> None:
        """What is laid over the picture and moves all the time."""
        pose, ground, about = self.pose, self.pose.ground + _ABOVE, np.array([*self._place, 0.0])
        self._draw_support(ground)
        zmp = pose.zmp - self._place
        self._zmp.position = (*np.nan_to_num(zmp), ground)
        _show(self._zmp, bool(np.isfinite(zmp).all()))
        x, y, z = self._com.position = frame.com - about
        self._com_below.position = (x, y, ground + _ABOVE)
        _place(self._com_line, np.array([((x, y, ground), (x, y, z))]))
        for row, lines in enumerate(self._planned):
            wanted = pose.foothold if pose.foothold is not None and row == pose.swing else None
            _place(lines, None if wanted is None else _outline(wanted - about + _LIFTED))
        forces = frame.contacts[frame.contacts[:, 5] > 0.002 * self._weight]
        feet, length = forces[:, :3] - about, 0.9 * self.size / self._weight
        _place(self._forces, np.stack([feet, feet + length * forces[:, 3:]], axis=1) if len(forces) else None)
        began, force = self._pushed
        size = float(np.linalg.norm(force))
        arrow = None
        if self._time - began <= _PUSH_SEEN and size > 0.0:
            way, length = force / size, self.size * min(0.3 + 0.5 * size / self._weight, 1.2)
            tip = pose.torso_centre - about - _CLEAR * self.size * way
            arrow = np.array([[tip - length * way, tip]])
        _place(self._push, arrow)

    def _draw_support(self, ground: float) -> None:
        """Support polygon: its area, and its edge."""
        corners = self.pose.support - self._place
        flat = np.column_stack([corners, np.full(len(corners), ground)])
        _place(self._support_edge, _outline(flat) if len(flat) > 1 else None)
        _show(self._support, len(flat) > 2)
        if len(flat) > 2:
            corner = np.minimum(np.arange(len(self._support.vertices)), len(flat) - 1)
            self._support.vertices = flat[corner].astype(np.float32)

    def _draw_trails(self) -> None:
        """The ways of both feet."""
        while self._trail and self._trail[0][0] < self._time - _TRAIL:
            self._trail.popleft()
        way = np.array([places for _, places in self._trail]) - (*self._place, 0.0)
        for row, lines in enumerate(self._trails):
            _place(lines, np.stack([way[:-1, row], way[1:, row]], axis=1) if len(way) > 1 else None)

    def _draw_prints(self) -> None:
        """Where both feet stood."""
        self._steps_changed = False
        if not self._prints:
            _place(self._printed, None)
            return
        outlines = [(_outline(corners + _LIFTED), SIDES[row]) for row, corners in self._prints]
        colours = [np.tile(np.array(colour, dtype=np.uint8), (len(lines), 2, 1)) for lines, colour in outlines]
        self._printed.remove()
        self._printed = self._server.scene.add_line_segments(
            "/world/steps/outline",
            np.concatenate([lines for lines, _ in outlines]),
            np.concatenate(colours),
            thickness=0.007 * self.size,
        )


def _place(handle: Any, points: npt.NDArray[Any] | None) -> None:
    """Where lines or arrows are, (n, 2, 3); None hides them."""
    if points is not None:
        handle.points = points.astype(np.float32)
    _show(handle, points is not None)


def _show(handle: Any, visible: bool) -> None:
    """Show or hide something, if it is not so already."""
    if handle.visible != visible:
        handle.visible = visible


def _turned(pitch: float, roll: float) -> tuple[float, float, float, float]:
    """Quaternion w x y z of a block, of whose angles one is zero."""
    half = 0.5 * (pitch or roll)
    return (math.cos(half), math.sin(half) if roll else 0.0, math.sin(half) if pitch else 0.0, 0.0)


def _sky() -> npt.NDArray[np.uint8]:
    """(n, 2, 3) colours behind everything, from top to bottom."""
    share = np.linspace(0.0, 1.0, 256)[:, None, None]
    colours = (1.0 - share) * np.array([176, 196, 220]) + share * np.array([240, 243, 247])
    return np.broadcast_to(colours, (256, 2, 3)).astype(np.uint8)


def _outline(corners: Array) -> npt.NDArray[np.float32]:
    """(k, 2, 3) edges of a polygon; of a line twice the same."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float32)
