"""What became of a grid of pushes: direction around the circle, phase of the stride outwards."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.projections.polar import PolarAxes

from gaitsmith.errors import BadInput
from gaitsmith.view.canvas import LEFT, LIMIT, figure

_HUB = 0.35  # share of the radius left free in the middle, so that the inner cells can be seen
_LEVELS = 8  # of a scale
_FELL, _LATE = "#D55E00", "#F6D7B8"  # at once, and just before the end
_STOOD, _SLOW, _NOT_RUN = LEFT, "#C6DDEE", "#FFFFFF"


def draw_push_map(
    title: str, seconds: npt.ArrayLike, limit: float, recovered: npt.ArrayLike | None = None, offset: float = 0.0
) -> Figure:
    """Polar map of survival: one sector per direction of the push, one ring per phase of the stride.

    Args:
        seconds: (n_directions, n_phases) time upright after the push, s; NaN where not run. Directions go evenly
            counter-clockwise from forward, phases evenly from the beginning of a left stance.
        limit: time that counts as survived, s.
        recovered: (n_directions, n_phases) time until the walk was itself again, s; NaN where it never was. Survivors
            are shaded by it.
        offset: of the first direction from forward, degrees.

    Raises:
        BadInput: ``seconds`` is not a matrix, or ``limit`` is not positive.
    """
    times = np.asarray(seconds, dtype=np.float64)
    if times.ndim != 2 or not times.size:
        raise BadInput("seconds", times.shape, "a row per direction and a column per phase")
    if not limit > 0.0:
        raise BadInput("limit", limit, "more than 0 s")
    stood, run = times >= limit - 1e-9, np.isfinite(times)
    with figure(f"{title}: {np.count_nonzero(stood)} of {np.count_nonzero(run)} survived", 6.4) as made:
        axis = made.add_subplot(projection="polar")
        assert isinstance(axis, PolarAxes)
        shades = LinearSegmentedColormap.from_list("fall", [_FELL, _LATE], _LEVELS)
        n_directions, n_phases = times.shape
        width, height = 2.0 * np.pi / n_directions, (1.0 - _HUB) / n_phases
        again = np.full(times.shape, np.nan) if recovered is None else np.asarray(recovered, dtype=np.float64)
        calm = _calm(again[stood])
        tints = np.zeros((*times.shape, 4)) if calm is None else calm.to_rgba(again)
        for (i, k), time in np.ndenumerate(times):
            place = (np.radians(offset) + i * width, height, width, _HUB + k * height)
            colour = _STOOD
            if not stood[i, k]:
                colour = to_hex(shades(float(time / limit))) if run[i, k] else _NOT_RUN
            elif calm is not None:
                colour = to_hex(tuple(tints[i, k].tolist())) if np.isfinite(again[i, k]) else _SLOW
            axis.bar(*place, color=colour, edgecolor="white", linewidth=1.0, zorder=2)
        _label(axis, n_directions, n_phases, offset)
        marks: list[Artist] = []
        if calm is None:
            marks.append(Patch(facecolor=_STOOD, label=f"upright for {limit:g} s"))
        else:
            made.colorbar(calm, ax=axis, label=f"upright for {limit:g} s, recovered after, s", shrink=0.6, pad=0.12)
        never = np.argwhere(stood & ~np.isfinite(again))
        if len(never) and recovered is not None:
            places = [(np.radians(offset) + i * width, _HUB + (k + 0.5) * height) for i, k in never]
            label = "upright, but never calm, or the legs touched"
            marks += axis.plot(*np.transpose(places), "x", color="black", ms=5.0, zorder=4, label=label)
        if not run.all():
            marks.append(Patch(facecolor=_NOT_RUN, edgecolor=LIMIT, label="not run"))
        if n_phases % 2 == 0:  # the right stance begins half way
            around = np.linspace(0.0, 2.0 * np.pi, 200)
            half = np.full(200, _HUB + height * n_phases / 2)
            marks += axis.plot(around, half, color="black", lw=0.8, zorder=3, label="right stance begins")
        if np.any(~stood & run):
            scale = ScalarMappable(Normalize(0.0, limit), shades)
            made.colorbar(scale, ax=axis, label="fell after the push, s", shrink=0.6, pad=0.12)
        made.legend(handles=marks, loc="outside lower right")
    return made


def _calm(seconds: npt.NDArray[np.float64]) -> ScalarMappable | None:
    """Shades of recovery times, s, in half seconds from the shortest to the longest; None without any."""
    known = seconds[np.isfinite(seconds)]
    if not known.size:
        return None
    least = np.floor(2.0 * known.min()) / 2.0
    most = max(np.ceil(2.0 * known.max()) / 2.0, least + 0.5)
    levels = min(max(round(2.0 * (most - least)), 2), _LEVELS)
    return ScalarMappable(Normalize(least, most), LinearSegmentedColormap.from_list("calm", [_STOOD, _SLOW], levels))


def _label(axis: PolarAxes, n_directions: int, n_phases: int, offset: float) -> None:
    """Forward is up and left is left, as seen from above."""
    axis.set_theta_zero_location("N")
    axis.set_ylim(0.0, 1.0)
    axis.grid(visible=False)
    axis.spines["polar"].set_visible(False)
    names = {0: "forward", 90: "left", 180: "back", 270: "right"}
    degrees = ((offset + np.arange(n_directions) * 360.0 / n_directions) % 360.0).tolist()
    axis.set_xticks(np.radians(degrees).tolist(), [names.get(round(angle, 6), f"{angle:g}°") for angle in degrees])
    axis.set_yticks([])
    words = "phase of\nthe stride\ninside 0,\noutside 1" if n_phases > 1 else "one phase of\nthe stride"
    axis.text(0.0, 0.0, words, ha="center", va="center", fontsize=9.0)
