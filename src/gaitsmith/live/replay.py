"""The page of a run that was recorded: a time slider, what happened when, and the same picture and charts."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from gaitsmith.live.buttons import button_row
from gaitsmith.live.charts import Charts, History
from gaitsmith.live.controls import PACES, clamped
from gaitsmith.live.page import PERIOD, add_overlay_switches, banner
from gaitsmith.live.run import Run
from gaitsmith.live.scene import Scene
from gaitsmith.live.server import Server, listen
from gaitsmith.live.session import token_for
from gaitsmith.live.timeline import drawn, timeline_of
from gaitsmith.live.walker import REGION

_CHARTED = 10.0  # s before the present that the charts show
_BEFORE = 0.5  # s before a moment at which a look at it begins
_MARKS = 12
_COLOURS = ("#2d7dd2", "#e6732d", "#8a94a3")
_HINT = (
    "Black: the fall. Red: pushes. Yellow: limits reached. Blue and orange: touchdowns. Contact forces are drawn at "
    "the planned centres of pressure: a log holds no others."
)


class Replay:
    """A recorded run on a page.

    Attributes:
        address: to open in a browser.
        at: the time that is shown, s.
        playing: whether it goes on.

    Raises:
        BadInput: the port is in use.
    """

    def __init__(self, run: Run, host: str, port: int) -> None:
        self._run, self._server = run, Server(listen(host, port), token_for(host), run.robot.card.name)
        self.address = self._server.address
        self._begin, self._end = float(run.log.time[0]), float(run.log.time[-1])
        self._timeline = timeline_of(run)
        self.at, self.playing, self._pace = self._begin, True, 1.0
        self._shown, self._drawn_at, self._count = -1, -math.inf, 0
        gui = self._server.gui
        gui.configure_theme(brand_color=(45, 125, 210), show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(340)
        self._status = gui.add_html("")
        self._add_player()
        self._scene = Scene(self._server, run.robot, 0)
        self._scene.set_ground(run.scenario.terrain, run.scenario.seed, REGION)
        add_overlay_switches(self._server, self._scene)
        self._history = History(run.robot, _CHARTED, 0.02)
        charts = gui.add_panel()
        with charts.add_tab("10 seconds up to now"):
            self._charts = Charts(self._server, self._history, without=("tick",))
        charts.dock_left()
        charts.set_width(400)

    def _add_player(self) -> None:
        """Time slider, buttons, and the timeline."""
        gui, timeline = self._server.gui, self._timeline
        marks = [(span.begin, "push") for span in timeline.pushes[:_MARKS]]
        marks += [(timeline.fall, "fall")] if timeline.fall is not None else []
        step = max(round((self._end - self._begin) / 2000.0, 3), 0.001)
        self._slider = gui.add_slider("Time, s", self._begin, self._end, step, self._begin, marks=tuple(marks))

        async def moved(event: Any) -> None:
            if event.client_id is None:  # the page itself has moved it
                return
            self.at = clamped(self._slider.value, self._begin, self._end, self.at)
            self.playing = False

        self._slider.on_update(moved)
        button_row(
            self._server,
            "Play",
            {"Play / pause": self.toggle, "◀ event": lambda: self.jump(-1), "event ▶": lambda: self.jump(1)},
        )
        button_row(self._server, "Time", {name: partial(self._set_pace, pace) for name, pace in PACES.items()})
        gui.add_html(drawn(timeline, self._begin, self._end, _COLOURS))
        gui.add_markdown(f"*{_HINT}*")

        async def space(_: Any) -> None:
            self.toggle()

        gui.add_command("Play or pause", hotkey="space").on_trigger(space)

    def toggle(self) -> None:
        """Play, from the beginning if it is over; or pause."""
        if not self.playing and self.at >= self._end:
            self.at = self._begin
        self.playing = not self.playing

    def jump(self, way: int) -> None:
        """Go to just before the next push or fall, or the one before."""
        moments = [max(moment - _BEFORE, self._begin) for moment in self._timeline.moments]
        if way > 0:
            self.at = min((moment for moment in moments if moment > self.at + 1e-3), default=self._end)
        else:
            self.at = max((moment for moment in moments if moment < self.at - 1e-3), default=self._begin)

    def _set_pace(self, factor: float) -> None:
        self._pace = factor

    def update(self, passed: float) -> None:
        """Go on by the wall time that has passed, s, and show what there is then."""
        if self.playing:
            self.at = min(self.at + passed * self._pace, self._end)
            self.playing = self.at < self._end
        number = self._run.row(self.at)
        self._count += 1
        if number == self._shown:
            return
        frame = self._run.show(number)
        self._scene.show(frame, slow=self._count % 3 == 0)
        if self._count % 4 == 0 or not self.playing:
            self._shown = number if not self.playing else -1
            self._slider.value = round(self.at, 2)
            self._draw_charts(number)
            self._status.content = self._state()

    def _draw_charts(self, number: int) -> None:
        """The last seconds up to a row."""
        first = self._run.row(self._run.log.time[number] - _CHARTED)
        known = self._history.rows[-1, 0] if len(self._history.rows) else -math.inf
        if not self._run.log.time[first] <= known <= self._run.log.time[number]:
            self._history.clear()
        else:
            first = self._run.row(known) + 1
        self._history.add(self._run.frame, self._run.rows(first, number + 1))
        self._charts.draw()

    def _state(self) -> str:
        """What is shown, as HTML."""
        run, frame, dark = self._run, self._run.frame, "#2b323b"
        fallen = self._timeline.fall is not None and self.at >= self._timeline.fall - 1e-6
        title, colour = ("Playing", "#3caf5a") if self.playing else ("Paused", "#eba614")
        if fallen and run.fall is not None:
            title, colour = f"Fell at {run.fall.time:.2f} s", "#d62828"
        mean = self._history.rows[-1, 3] if len(self._history.rows) else 0.0
        tiles = [
            ("time", f"{self.at:.2f} s", dark),
            ("speed", f"{mean:.2f} m/s", dark),
            ("steps", f"{int(frame['step_count'])}", dark),
            ("robot", run.robot.card.name, dark),
            ("pushes", f"{len(self._timeline.pushes)}", dark),
            ("limits", f"{len(self._timeline.limits)}", dark),
        ]
        words = " ".join(run.notes)
        if run.fall is not None and (fallen or not self.playing):
            words = f"{run.fall.reason} ({run.fall.phase}). {words}"
        return banner(title, colour, tiles, words)

    def run(self, look: Callable[[], None] = lambda: None) -> None:
        """Until ``look``, called before every picture, raises."""
        before = time.monotonic()
        while True:
            look()
            now = time.monotonic()
            self.update(now - before)
            before = now
            time.sleep(max(0.002, PERIOD - (time.monotonic() - now)))

    def close(self) -> None:
        """Close the page."""
        self._server.stop()
