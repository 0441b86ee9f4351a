"""A walk in a process of its own, with its page in this one."""

import threading
from collections.abc import Iterator

import pytest
from tests.live.bench import Bench

from gaitsmith.live.recording import finish_folder
from gaitsmith.live.session import Session
from gaitsmith.live.wishes import Kind
from gaitsmith.robots import load_robot


class Steered:
    """A session whose page is kept up to date in a thread."""

    def __init__(self, folder):
        scenario = {"robot": "thbip_ii", "speed": [0.2, 0.0], "duration": 1e6}
        self.session = Session(scenario, load_robot("thbip_ii"), "127.0.0.1", 0, str(folder))
        self.address, self.page, self._stop = self.session.address, self.session.page, False
        self._thread = threading.Thread(target=self.page.run, args=(lambda: not self._stop,), daemon=True)
        self._thread.start()

    def close(self):
        self._stop = True
        self._thread.join(30.0)
        assert not self._thread.is_alive()
        return self.session.close()


@pytest.fixture(scope="module")
def steered(tmp_path_factory) -> Iterator[Steered]:
    made = Steered(tmp_path_factory.mktemp("runs"))
    yield made
    made.close()


@pytest.fixture(scope="session")
def fallen(tmp_path_factory):
    """Folder of a run of 3 s that a push at 2 s has ended."""
    bench = Bench(tmp_path_factory.mktemp("runs"), robot="bhr_b2", speed=[0.3, 0.0])
    bench.wish(Kind.RECORD, 1.0)
    bench.ticks(2000)
    bench.wish(Kind.PUSH, 0.0, 90.0, 0.0)
    bench.ticks(3000)
    folder = bench.walker._recording.done
    assert finish_folder(folder) == ""
    bench.close()
    return folder
