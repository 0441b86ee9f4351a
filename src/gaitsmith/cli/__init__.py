"""The command line: one file a command, exit codes and messages in one place.

Importing this package costs next to nothing, so that Ctrl-C is heard before anything that takes time.
"""

from __future__ import annotations

import gc
import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


def main(words: Sequence[str] | None = None) -> int:
    """Run one command line.

    Args:
        words: the command line without the program's name. None takes the process's own, and Ctrl-C has no effect any
            more once this returns: the process is ending, with the code returned here, and looks for no garbage.

    Returns:
        0 done, 1 the robot fell or a gait file is not right, 2 bad input, 3 not solved or not certified, 70 an error
        of the package itself, 130 interrupted.
    """
    try:
        from gaitsmith.cli.interrupts import Interrupts

        with Interrupts(ending=words is None) as interrupts:
            from gaitsmith.cli.dispatch import run

            return run(list(sys.argv[1:] if words is None else words), interrupts)
    except KeyboardInterrupt:
        if words is None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        os.write(2, b"gaitsmith: interrupted: nothing was recorded yet\n")
        return 130
    finally:
        if words is None:
            gc.freeze()  # or the interpreter's end looks through all that libraries have made: a fifth of a second
