"""Means over whole stride pairs, on signals whose mean is known."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.simulation.stages import Signals, Span, measure_stage, scored_window
from gaitsmith.simulation.summary import Stage, StageCommand

DT = 1e-3
COMMAND = StageCommand(vx=0.4, vy=0.1, period=0.4, alpha=0.5, height=0.7, lift=0.1, width=0.0375, yaw_rate=0.3)


def _walk(step_ticks: int, n: int) -> np.ndarray:
    """Touchdowns of an even walk."""
    ticks = np.arange(0, n, step_ticks)
    return np.stack([ticks, np.arange(len(ticks)) % 2], axis=1)


def _signals(step_ticks: int, n: int, start: int = 0) -> Signals:
    """Signals whose speed swings once a step and sways once a stride about the command; so does the torso."""
    ticks = np.arange(start, n)
    turn = 2 * np.pi * ticks / step_ticks
    sway = 0.05 * np.cos(turn / 2)
    ahead, left = 0.4 + 0.2 * np.sin(turn), 0.1 + 0.3 * np.cos(turn / 2)
    return Signals(
        speed_x=np.cos(sway) * ahead + np.sin(sway) * left,
        speed_y=np.cos(sway) * left - np.sin(sway) * ahead,
        height=0.7 + 0.01 * np.sin(turn),
        roll=np.radians(0.3) * np.sin(turn / 2),
        pitch=np.zeros(n - start),
        heading=0.3 * DT * ticks + sway,
    )


def _measured(span: Span, signals: Signals, start: int, touchdowns: np.ndarray) -> Stage:
    return measure_stage(span, start, signals, touchdowns, (-0.01, 0.02), (-0.03, 0.0), 0.1, DT)


@given(st.integers(150, 480), st.integers(0, 400), st.booleans())
def test_periodic_speed_averages_out_whatever_the_step(step_ticks, offset, whole):
    n = 4000 + offset
    start = 0 if whole else n - 2001
    stage = _measured(Span(offset, n, False, COMMAND), _signals(step_ticks, n, start), start, _walk(step_ticks, n))
    # Whole strides of a sampled sine sum to zero up to rounding.
    assert stage.vx_error == pytest.approx(0.0, abs=1e-12)
    assert stage.vy_error == pytest.approx(0.0, abs=1e-12)
    assert stage.height_error == pytest.approx(0.0, abs=1e-12)
    assert stage.yaw_rate_mean == pytest.approx(0.3, abs=1e-12)
    assert stage.yaw_rate_error == pytest.approx(0.0, abs=1e-12)


@given(st.integers(700, 1300), st.integers(0, 2500))
def test_a_plan_is_measured_over_all_strides_of_its_loop_that_are_remembered(step_ticks, loop):
    """In front of the loop it walked slower."""
    n = loop + 6 * step_ticks
    begin, end = scored_window(0, n, _walk(step_ticks, n), DT, loop)
    assert begin >= max(loop, n - 8000)
    assert end - begin == 4 * step_ticks  # two strides; without its loop the latest one at most
    begin, end = scored_window(0, n, _walk(step_ticks, n), DT)
    assert end - begin == 2 * step_ticks


def test_a_plan_without_a_loop_is_measured_as_a_whole():
    n = 3000
    span = Span(0, n, False, COMMAND, None, (0.6, -0.03))
    stage = _measured(span, _signals(400, n), 0, _walk(400, n))
    assert (stage.scored, stage.vx_mean, stage.vy_mean) == ((0.0, 3.0), pytest.approx(0.2), pytest.approx(-0.01))


@given(st.lists(st.integers(100, 2500), min_size=2, max_size=40), st.integers(0, 1))
def test_the_window_is_whole_stride_pairs_inside_the_last_two_seconds_or_the_latest_stride(lengths, leg):
    ticks = np.cumsum(lengths)
    touchdowns = np.stack([ticks, (np.arange(len(ticks)) + leg) % 2], axis=1)
    last = int(ticks[-1]) + 37
    begin, end = scored_window(0, last, touchdowns, DT)
    assert max(0, last - 8000) <= begin < end <= last
    inside = [i for i, tick in enumerate(ticks) if begin <= tick <= end]
    earliest = max(0, last - 8000)
    fits = [(i, j) for i in range(len(ticks)) for j in range(i + 2, len(ticks), 2) if ticks[i] >= max(0, last - 2000)]
    pairs = [(j - i) // 2 for i, j in fits]
    if not pairs:
        known = ticks[ticks >= earliest]
        assert (begin, end) == ((known[-3], known[-1]) if len(known) > 2 else (max(0, last - 2000), last))
        return
    strides = (len(inside) - 1) // 2
    assert ticks[inside[0]] == begin
    assert ticks[inside[-1]] == end
    even = [p for p in pairs if p % 2 == 0]
    assert strides == (max(even) if even else 1)


def test_ranges_are_in_degrees_and_a_stage_goes_into_json():
    stage = _measured(Span(0, 4000, False, COMMAND), _signals(400, 4000), 0, _walk(400, 4000))
    assert stage.settled_roll_deg == pytest.approx((-0.3, 0.3), abs=1e-6)
    assert stage.roll_deg == pytest.approx((np.degrees(-0.01), np.degrees(0.02)))
    assert stage.heading_drift_deg == pytest.approx(np.degrees(0.1))
    json.dumps(stage.model_dump(mode="json"), allow_nan=False)
    assert Stage.model_validate_json(stage.model_dump_json()) == stage


def test_a_single_tick_is_a_stage():
    stage = _measured(Span(3, 4, True, COMMAND), _signals(400, 4), 0, _walk(400, 4))
    assert (stage.t0, stage.t1, stage.rest) == (0.003, 0.004, True)
