"""Means over whole stride pairs, on signals whose mean is known."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.simulation.summary import Span, StageCommand, measure_stages, scored_window, tick_times

DT = 1e-3
COMMAND = StageCommand(vx=0.4, vy=0.1, period=0.4, alpha=0.5, height=0.7, lift=0.1, width=0.0375, yaw_rate=0.0)


def _walk(step_ticks: int, n: int) -> np.ndarray:
    """Touchdowns of an even walk."""
    ticks = np.arange(0, n, step_ticks)
    return np.stack([ticks, np.arange(len(ticks)) % 2], axis=1)


def _signal(step_ticks: int, n: int) -> np.ndarray:
    """Vitals whose speed swings once a step and sways once a stride about the command."""
    turn = 2 * np.pi * np.arange(n) / step_ticks
    vitals = np.zeros((n, 8))
    vitals[:, 0] = 0.4 + 0.2 * np.sin(turn)
    vitals[:, 1] = 0.1 + 0.3 * np.cos(turn / 2)
    vitals[:, 2] = 0.7 + 0.01 * np.sin(turn)
    vitals[:, 3] = np.radians(0.3) * np.sin(turn / 2)
    return vitals


@given(st.integers(150, 480), st.integers(0, 400))
def test_periodic_speed_averages_out_whatever_the_step(step_ticks, offset):
    n = 4000 + offset
    stages = measure_stages([Span(offset, n, False, COMMAND)], _signal(step_ticks, n), _walk(step_ticks, n), DT)
    # Whole strides of a sampled sine sum to zero up to rounding.
    assert stages[0].vx_error == pytest.approx(0.0, abs=1e-12)
    assert stages[0].vy_error == pytest.approx(0.0, abs=1e-12)
    assert stages[0].height_error == pytest.approx(0.0, abs=1e-12)


@given(st.lists(st.integers(100, 600), min_size=2, max_size=40), st.integers(0, 1))
def test_the_window_is_whole_stride_pairs_inside_the_last_two_seconds(lengths, leg):
    ticks = np.cumsum(lengths)
    touchdowns = np.stack([ticks, (np.arange(len(ticks)) + leg) % 2], axis=1)
    last = int(ticks[-1]) + 37
    begin, end = scored_window(0, last, touchdowns, DT)
    assert max(0, last - 2000) <= begin < end <= last
    inside = [i for i, tick in enumerate(ticks) if begin <= tick <= end]
    fits = [(i, j) for i in range(len(ticks)) for j in range(i + 2, len(ticks), 2) if ticks[i] >= max(0, last - 2000)]
    pairs = [(j - i) // 2 for i, j in fits]
    if not pairs:
        assert (begin, end) == (max(0, last - 2000), last)
        return
    strides = (len(inside) - 1) // 2
    assert ticks[inside[0]] == begin
    assert ticks[inside[-1]] == end
    even = [p for p in pairs if p % 2 == 0]
    assert strides == (max(even) if even else 1)


def test_a_stage_cut_short_is_measured_as_far_as_it_went():
    spans = [Span(0, 1000, True, COMMAND), Span(1000, 5000, False, COMMAND), Span(5000, 9000, False, COMMAND)]
    stages = measure_stages(spans, _signal(400, 3000), _walk(400, 3000), DT)
    assert [(stage.t0, stage.t1) for stage in stages] == [(0.0, 1.0), (1.0, 3.0)]
    assert stages[0].rest
    json.dumps(stages[1].model_dump(mode="json"), allow_nan=False)


def test_ranges_are_in_degrees():
    stage = measure_stages([Span(0, 4000, False, COMMAND)], _signal(400, 4000), _walk(400, 4000), DT)[0]
    assert stage.roll_deg == pytest.approx((-0.3, 0.3), abs=1e-6)
    assert stage.settled_roll_deg == pytest.approx((-0.3, 0.3), abs=1e-6)


def test_tick_times_count_overruns():
    times = tick_times(np.array([20_000] * 98 + [1_500_000, 2_000_000], dtype=np.int64), DT)
    assert times.median == 20.0
    assert times.overruns == 2
    assert times.max == 2000.0
    assert tick_times(np.zeros(0, dtype=np.int64), DT).max == 0.0
