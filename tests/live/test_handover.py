"""What one process writes, another reads, in order and whole, or not at all; the writer never waits."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.live.handover import Note, Ring


@pytest.fixture
def ring():
    made = Ring(3, 8)
    yield made
    made.close()


def test_a_reader_gets_every_row_in_order(ring):
    reader, seen = Ring(3, 8, ring.name), 0
    for k in range(5):
        ring.write((k, k, k))
    rows, seen = reader.read(seen)
    np.testing.assert_array_equal(rows[:, 0], range(5))
    assert len(reader.read(seen)[0]) == 0
    reader.close()


def test_a_reader_that_never_reads_costs_the_writer_nothing_and_sees_the_latest(ring):
    for k in range(1000):
        ring.write((k, -k, 0.5))
    rows, end = ring.read(0)
    np.testing.assert_array_equal(rows[:, 0], range(992, 1000))
    assert end == ring.written == 1000
    np.testing.assert_array_equal(ring.read(0, 1)[0], [(999, -999, 0.5)])


def test_a_row_that_is_being_overwritten_is_left_out(ring):
    for k in range(8):
        ring.write((k, k, k))
    ring._rows[3, 0] = -1.0  # as while it is written
    np.testing.assert_array_equal(ring.read(0)[0][:, 0], [0, 1, 2, 4, 5, 6, 7])
    ring._rows[3, 0], ring._rows[4, -1] = 3.0, -1.0
    np.testing.assert_array_equal(ring.read(0)[0][:, 0], [0, 1, 2, 3, 5, 6, 7])


def test_a_note_says_the_latest_and_only_once():
    note = Note()
    reader = Note(note.name)
    assert reader.read(0) == ({}, 0)
    note.write({"a": 1})
    note.write({"a": 2})
    words, seen = reader.read(0)
    assert words == {"a": 2}
    assert reader.read(seen) == ({}, seen)
    note._head[0] += 1  # as while it is written
    assert reader.read(0) == ({}, 0)
    note.write({"long": "x" * 100_000})
    assert reader.read(seen) == ({}, seen)
    reader.close()
    note.close()
