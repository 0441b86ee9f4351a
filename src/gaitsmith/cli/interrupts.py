"""Ctrl-C, SIGTERM and SIGHUP: heard once, however often they come, and never the end of the process by a signal."""

from __future__ import annotations

import signal
import sys
import threading
import time

from gaitsmith.files import ENDING

_heard = threading.Event()
_LATER = 0.1  # s until a wish that a callback swallowed is raised again
_SAME = 2.0  # s within which Ctrl-C pressed again, or passed on by a wrapper, is the same wish


class Interrupts:
    """Context in which Ctrl-C raises KeyboardInterrupt and is noted: a library may turn the exception into another.

    SIGTERM and SIGHUP, which end a session or a batch job, do the same. A signal that is ignored already (a job in the
    background) stays ignored, and in other threads nothing changes. With ``ending`` the process ends after this, and
    Ctrl-C is ignored from then on, or it would end it with a signal.
    """

    def __init__(self, ending: bool = False) -> None:
        self.seen = False  # whether Ctrl-C was pressed
        self.over = False  # set when the command has ended: Ctrl-C has nothing left to stop
        self._ending = ending
        self._last = -_SAME
        self._before: dict[int, object] = {}
        self._again: threading.Timer | None = None

    def __enter__(self) -> Interrupts:
        _heard.clear()
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                if signal.getsignal(number) in (signal.default_int_handler, signal.SIG_DFL):
                    self._before[number] = signal.signal(number, self._note)
        sys.unraisablehook, self._hook = self._swallowed, sys.unraisablehook
        return self

    def __exit__(self, *_: object) -> None:
        sys.unraisablehook = self._hook
        if self._again is not None:
            self._again.cancel()
        for number, before in self._before.items():
            signal.signal(number, signal.SIG_IGN if self._ending else before)  # type: ignore[arg-type]

    def _swallowed(self, lost: sys.UnraisableHookArgs) -> None:
        """An exception that a compiler's callback could not pass on: a wish to end is raised again, a little later."""
        if not (self._before and self.seen and issubclass(lost.exc_type, KeyboardInterrupt)):
            self._hook(lost)
        elif not self.over:
            self._last = -_SAME
            self._again = threading.Timer(_LATER, signal.raise_signal, (next(iter(self._before)),))
            self._again.daemon = True
            self._again.start()

    def _note(self, *_: object) -> None:
        now, before = time.monotonic(), self._last
        self.seen, self._last = True, now
        _heard.set()
        if not self.over and now - before >= _SAME:
            raise KeyboardInterrupt


def stop_if_heard() -> None:
    """Raise what a signal has raised already, should a library have swallowed it: called now and then by a long run."""
    if _heard.is_set():
        raise KeyboardInterrupt
