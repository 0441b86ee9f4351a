"""The limit named first is the one that was hit first and for long enough, since the last step without any."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitsmith.robots.sole import Sole
from gaitsmith.simulation.limits import Bounds, Seen, find_hits, make_hits, remember_hits
from gaitsmith.simulation.monitor import TILTED
from gaitsmith.simulation.report import explain
from gaitsmith.whole_body.legs import edge_table

DT = 1e-3
KNEE, FRICTION, LEGS = 0, 12, 14  # places of three limits for one joint and two soles
NO_EDGE = (np.zeros(2, dtype=np.int64), np.zeros((2, 1, 3)))
BOUNDS = Bounds(
    *(np.zeros(2) for _ in range(4)), *NO_EDGE, reach=0.0, spread=0.0, zmp_margin=0.0, friction=0.0, contact=0.0, dt=DT
)


def _seen() -> Seen:
    seen = Seen(*(np.zeros(12) for _ in Seen._fields))
    seen.mode[0], seen.period[0] = 1.0, 0.4
    return seen


def _remembered(flags: np.ndarray, steps: set[int], seen: Seen | None = None) -> dict[str, int]:
    """First hits after flags (ticks, 3) of the three limits, with steps that begin at some ticks."""
    hits, names = make_hits(("knee",), ("left", "right"), DT)
    for tick, row in enumerate(flags):
        hits.now[[KNEE, FRICTION, LEGS]] = row
        remember_hits(seen or _seen(), BOUNDS, hits, tick, tick in steps)
    return {name: int(tick) for name, tick in zip(names, hits.first, strict=True) if tick >= 0}


NAMES = ("torque of knee saturated", "friction limit of the left sole", "legs touching each other")


@settings(max_examples=25)
@given(
    st.integers(10, 400),
    st.lists(st.tuples(st.integers(0, 2), st.integers(0, 400), st.integers(1, 60)), max_size=5),
    st.sets(st.integers(1, 399), max_size=6),
)
def test_hits_are_found_where_they_began(ticks, stretches, steps):
    flags = np.zeros((ticks, 3), dtype=np.int64)
    for column, start, length in stretches:
        flags[start : start + length, column] = 1
    needs = (5, 5, 1)
    held = np.zeros((ticks, 3), dtype=bool)  # counts at this tick
    for column, need in enumerate(needs):
        for tick in range(need - 1, ticks):
            held[tick, column] = flags[tick - need + 1 : tick + 1, column].all()
    edges = [0, *sorted(step for step in steps if step < ticks), ticks]
    since = 0
    for begin, end in itertools.pairwise(edges):
        if end < ticks and not held[begin:end].any():
            since = end  # an undisturbed step: everything before is forgotten
    expected = {
        NAMES[column]: since + int(np.argmax(held[since:, column])) - needs[column] + 1
        for column in range(3)
        if held[since:, column].any()
    }
    assert _remembered(flags, steps) == expected


def test_a_limit_is_remembered_over_steps_that_hit_others():
    flags = np.zeros((5000, 3), dtype=np.int64)
    flags[100:120, 0] = 1
    for begin in range(400, 5000, 400):
        flags[begin + 50 : begin + 60, 1] = 1
    steps = set(range(400, 5000, 400))
    assert _remembered(flags, steps) == {NAMES[0]: 100, NAMES[1]: 450}


def test_standing_undisturbed_for_a_step_forgets():
    flags, seen = np.zeros((2000, 3), dtype=np.int64), _seen()
    seen.mode[0] = 0.0
    flags[100:300, 0] = 1
    assert _remembered(flags[:700], set(), seen) == {NAMES[0]: 100}
    assert _remembered(flags, set(), seen) == {}


def _monitor(hits: list[tuple[str, int]]) -> SimpleNamespace:
    dated = [(name, tick * DT) for name, tick in hits]
    return SimpleNamespace(state=TILTED, dated_hits=lambda time: dated)


def test_the_reason_names_the_first_limit_and_three_more():
    hits = [(name, 1000 * k) for k, name in enumerate("abcde", 1)]
    fall = explain(_monitor(hits), 5.0, "standing", {"gyro": 2, "knee": 0}, "a push")  # type: ignore[arg-type]
    reason = fall.reason
    assert (fall.cause.what, fall.cause.confirmed) == ("a push", None)
    assert "; first limit hit: a, at 1.000 s; then b at 2.000 s, c at 3.000 s, d at 4.000 s" in reason
    assert reason.endswith("ticks with replaced readings: 2 of gyro")
    fall = explain(_monitor([]), 5.0, "standing", {}, "")  # type: ignore[arg-type]
    assert "no limit was hit in the last step" in fall.reason


def test_the_sides_of_a_sole_are_edges_and_a_line_has_none():
    hits, names = make_hits(("knee",), ("left", "right"), DT)
    seen, width = _seen(), 0.05
    soles = (Sole(kind="rectangle", heel=0.1, toe=0.1, half_width=width), Sole(kind="line", heel=0.1, toe=0.1))
    edges, edge = edge_table(soles)
    joint = {name: np.ones(1) for name in ("torque", "velocity", "position_high")}
    bounds = BOUNDS._replace(edges=edges, edge=edge, **joint, position_low=-np.ones(1), friction=1.0)
    seen.wrench[[2, 8]] = 300.0
    for across, hit in ((0.9 * width, False), (-width, True), (width, True)):
        seen.zmp[[1, 3]] = across
        find_hits(seen, bounds, hits)
        found = {name for name, flag in zip(names, hits.now, strict=True) if flag}
        assert found == ({"ZMP at the edge of the left sole"} if hit else set())
