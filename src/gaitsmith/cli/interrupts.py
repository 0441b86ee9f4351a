"""Ctrl-C: heard once, for however often it is pressed, and never the end of the process by a signal."""

from __future__ import annotations

import signal
import threading
import time

_SAME = 2.0  # s within which Ctrl-C pressed again, or passed on by a wrapper, is the same wish


class Interrupts:
    """Context in which Ctrl-C raises KeyboardInterrupt and is noted: a library may turn the exception into another.

    Where Ctrl-C is ignored already (a job in the background), and in other threads, nothing changes.

    Args:
        ending: the process ends after this: Ctrl-C is ignored from then on, or it would end it with a signal.

    Attributes:
        seen: whether Ctrl-C was pressed.
        over: set when the command has ended: Ctrl-C has nothing left to stop.
    """

    def __init__(self, ending: bool = False) -> None:
        self.seen = False
        self.over = False
        self._ending = ending
        self._last = -_SAME
        self._ours = False

    def __enter__(self) -> Interrupts:
        usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        self._ours = usual and threading.current_thread() is threading.main_thread()
        if self._ours:
            signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, signal.SIG_IGN if self._ending else signal.default_int_handler)

    def _note(self, *_: object) -> None:
        now, before = time.monotonic(), self._last
        self.seen, self._last = True, now
        if not self.over and now - before >= _SAME:
            raise KeyboardInterrupt
