"""A loop without a page, in this process, as fast as it goes."""

from __future__ import annotations

from pathlib import Path

from gaitsmith.live.frame import Frame
from gaitsmith.live.handover import Ring
from gaitsmith.live.pace import Pace
from gaitsmith.live.walker import WISHES, Request, Walker
from gaitsmith.live.wishes import WIDTH, Wish


class Bench:
    def __init__(self, folder: Path, **scenario):
        self.wishes = Ring(WIDTH, WISHES)
        pace = Pace(1e-3, clock=lambda: 0.0, sleep=lambda _: None)
        pace._step = 0.0
        self.walker = Walker(Request({"duration": 1e6, **scenario}, str(folder)), self.wishes, pace)

    def wish(self, kind, *values):
        self.wishes.write(Wish(kind, values).row())

    def ticks(self, count):
        return sum(self.walker.turn() for _ in range(count))

    def seen(self) -> Frame:
        self.walker.publish(0.0)
        rows, _ = self.walker.frames.read(0, 1)
        self.walker.frame.row[:] = rows[-1]
        return self.walker.frame

    def close(self):
        for shared in (self.walker.frames, self.walker.note, self.wishes):
            shared.close()
