"""The page of a walk: picture, charts and controls, kept up to date from the frames of another process."""

from __future__ import annotations

import html
import time
from typing import Any

import numpy as np

from gaitsmith.live.charts import Charts, History
from gaitsmith.live.controls import Controls
from gaitsmith.live.desk import Desk
from gaitsmith.live.frame import Frame
from gaitsmith.live.gamepad import SCRIPT
from gaitsmith.live.handover import Note, Ring
from gaitsmith.live.scene import OVERLAYS, Scene
from gaitsmith.live.server import Server
from gaitsmith.live.walker import REGION
from gaitsmith.robots import Robot
from gaitsmith.simulation.orders import first_gait
from gaitsmith.simulation.scenario import make_scenario

PERIOD = 1.0 / 30.0
"""s between two pictures."""
_SLOW, _CHARTS, _STATUS = 3, 4, 8  # pictures between two of the same
_LATE = 0.1  # % of ticks that come late from which on it is said why
_TILE = (
    '<div style="flex:1 1 30%;min-width:92px"><div style="font-size:11px;color:#7a8594">{}</div>'
    '<div style="font-size:16px;font-weight:600;color:{}">{}</div></div>'
)


def add_overlay_switches(server: Server, scene: Scene) -> None:
    """A checkbox for every overlay, and one for the picture that follows."""
    with server.gui.add_folder("Show", expand_by_default=False):
        follow = server.gui.add_checkbox("Follow the robot", True)

        async def followed(_: Any) -> None:
            scene.follow = bool(follow.value)

        follow.on_update(followed)
        glass = server.gui.add_checkbox("See through the robot", False)

        async def seen_through(_: Any) -> None:
            scene.see_through(bool(glass.value))

        glass.on_update(seen_through)
        for name, label in OVERLAYS.items():
            box = server.gui.add_checkbox(label, True)

            async def switched(_: Any, name: str = name, box: Any = box) -> None:
                scene.show_overlay(name, bool(box.value))

            box.on_update(switched)


def banner(title: str, colour: str, tiles: list[tuple[str, str, str]], words: str = "") -> str:
    """The state in words and numbers, as HTML; ``words`` come from files and are escaped."""
    shown = "".join(_TILE.format(html.escape(name), tone, html.escape(value)) for name, value, tone in tiles)
    tail = f'<div style="font-size:12px;color:#5b6573;margin-top:6px">{html.escape(words)}</div>' if words else ""
    return (
        '<div style="padding:8px 12px 4px 12px;font-family:inherit">'
        f'<div style="display:inline-block;padding:2px 10px;border-radius:9px;background:{colour};color:white;'
        f'font-weight:600;margin-bottom:8px">{html.escape(title)}</div>'
        f'<div style="display:flex;flex-wrap:wrap;gap:4px 8px">{shown}</div>{tail}</div>'
    )


class Page:
    """The page of a walk.

    Args:
        frame: laid out as the frames are.
        frames: from the loop.
        note: from the loop.
        desk: to the loop.
        scenario: fields of the walk's scenario.
    """

    def __init__(
        self, server: Server, robot: Robot, frame: Frame, frames: Ring, note: Note, desk: Desk, scenario: dict[str, Any]
    ) -> None:
        self._server, self._robot, self.frame = server, robot, frame
        self._frames, self._note, self._desk = frames, note, desk
        self.words: dict[str, Any] = {}
        self._seen, self._noted, self._count = 0, 0, 0
        self._ground = ("flat", 0)
        self.history = History(robot)
        gait = {} if scenario.get("gait") else first_gait(make_scenario(scenario), robot).model_dump()
        gui = server.gui
        gui.configure_theme(brand_color=(45, 125, 210), show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(340)
        self._status = gui.add_html(banner("Loading", "#8a94a3", []))
        self.controls = Controls(server, robot, desk, gait)
        self.controls.add_buttons()
        if gait:
            self.controls.add_gait()
        self.controls.add_push()
        self.scene = Scene(server, robot, len(frame.balls))
        self.scene.on_drag(self.controls.pull)
        add_overlay_switches(server, self.scene)
        self.controls.add_ground(str(scenario.get("terrain", "flat")))
        self.controls.add_keys()
        server.run_in_browsers(SCRIPT)
        charts = gui.add_panel()
        with charts.add_tab("Last 10 seconds"):
            self.charts = Charts(server, self.history)
        charts.dock_left()
        charts.set_width(400)

    def update(self) -> None:
        """Hand over what is wished for, and show what has come."""
        self._desk.hand_over()
        words, self._noted = self._note.read(self._noted)
        if words:
            self.words = words
            ground = (str(words["terrain"]), int(words["seed"]))
            if ground != self._ground:
                self._ground = ground
                self.scene.set_ground(*ground, REGION)
        rows, self._seen = self._frames.read(self._seen)
        if not len(rows):
            return
        self.history.add(self.frame, rows)
        self.frame.row[:] = rows[-1]
        self._count += 1
        self.scene.show(self.frame, self._count % _SLOW == 0)
        self.controls.show_state(self.frame["live.paused"] != 0.0, self.frame["live.recording"] != 0.0)
        if self._count % _CHARTS == 0:
            self.charts.draw()
        if self._count % _STATUS == 0:
            self._status.content = self._state()

    def _state(self) -> str:
        """The state of the walk, as HTML."""
        frame, words = self.frame, self.words
        fall = words.get("fall")
        title, colour = ("Walking", "#3caf5a") if frame["mode"] > 0.0 else ("Standing", "#2d7dd2")
        if frame["live.over"]:
            title, colour = (f"Fell at {fall['time']:.2f} s", "#d62828") if fall else ("Ended", "#8a94a3")
        elif frame["live.paused"]:
            title, colour = "Paused", "#eba614"
        ticks, late = frame["live.ticks"], frame["live.late"]
        share = 100.0 * late / max(ticks, 1.0)
        dark, refused = "#2b323b", int(frame["live.refused"]) + self._desk.dropped + self._server.guard.refused
        mean = self.history.rows[-1, 3] if len(self.history.rows) else 0.0
        tiles = [
            ("time", f"{frame['live.time']:.1f} s", dark),
            ("speed", f"{mean:.2f} m/s", dark),
            ("steps", f"{int(frame['step_count'])}", dark),
            ("real time", f"× {frame['live.speed']:.2f}", dark),
            ("late ticks (> 1 ms)", f"{share:.2f} %", dark if share < _LATE else "#d62828"),
            ("of", f"{int(ticks)} ticks", dark),
        ]
        notes = [str(words.get("trouble") or "")]
        if fall:
            notes.append(f"{fall['reason']} ({fall['phase']}). Reset begins anew.")
        if words.get("recording"):
            notes.append(f"Recording to {words['recording']}")
        elif words.get("recorded"):
            notes.append(f"Recorded: gaitsmith live {words['recorded']}")
        if share >= _LATE and not words.get("first"):
            notes.append("Ticks wait for other programs: no real-time priority (CAP_SYS_NICE), or too slow for it.")
        if refused:
            notes.append(f"{refused} messages refused.")
        return banner(title, colour, tiles, " ".join(filter(None, notes)))

    def run(self, alive: Any) -> None:
        """Keep the page up to date as long as ``alive()``."""
        while alive():
            began = time.monotonic()
            self.update()
            time.sleep(min(max(0.002, PERIOD - (time.monotonic() - began)), PERIOD))  # whatever became of the clock


def make_frame(columns: list[str], robot: Robot, balls: int) -> Frame:
    """A frame as the loop lays it out."""
    frame = Frame(columns, robot.model.nq, balls)
    frame.row[:] = np.nan
    return frame
