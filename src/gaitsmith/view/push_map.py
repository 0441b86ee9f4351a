"""What became of a grid of pushes: direction around the circle, phase of the stride outwards."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.projections.polar import PolarAxes

from gaitsmith.errors import BadInput
from gaitsmith.view.canvas import LEFT, LIMIT, figure

_HUB = 0.35  # share of the radius left free in the middle, so that the inner cells can be seen
_FELL, _LATE = "#D55E00", "#F6D7B8"  # at once, and just before the end
_STOOD, _SLOW, _NOT_RUN = LEFT, "#C6DDEE", "#FFFFFF"


def draw_push_map(
    title: str, seconds: npt.ArrayLike, limit: float, recovered: npt.ArrayLike | None = None, offset: float = 0.0
) -> Figure:
    """Polar map of survival: one sector per direction of the push, one ring per phase of the stride.

    Args:
        title: of the figure.
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
        shades = LinearSegmentedColormap.from_list("fall", [_FELL, _LATE])
        n_directions, n_phases = times.shape
        width, height = 2.0 * np.pi / n_directions, (1.0 - _HUB) / n_phases
        calm = LinearSegmentedColormap.from_list("calm", [_STOOD, _SLOW])
        again = None if recovered is None else np.asarray(recovered, dtype=np.float64)
        slowest = 1.0 if again is None or not np.any(np.isfinite(again)) else float(np.ceil(np.nanmax(again)))
        for (i, k), time in np.ndenumerate(times):
            colour = _STOOD if again is None else to_hex(calm(float(np.nan_to_num(again[i, k] / slowest, nan=1.0))))
            if not stood[i, k]:
                colour = to_hex(shades(float(time / limit))) if run[i, k] else _NOT_RUN
            place = (np.radians(offset) + i * width, height, width, _HUB + k * height)
            axis.bar(*place, color=colour, edgecolor="white", linewidth=1.0, zorder=2)
        _label(axis, n_directions, offset)
        marks: list[Artist] = []
        if again is not None and np.any(np.isfinite(again[stood])):
            scale = ScalarMappable(Normalize(0.0, slowest), calm)
            made.colorbar(
                scale,
                ax=axis,
                label=f"upright for {limit:g} s, recovered after, s",
                shrink=0.6,
                pad=0.02 if np.any(~stood) else 0.12,
            )
        else:
            marks.append(Patch(facecolor=_STOOD, label=f"upright for {limit:g} s"))
        if again is not None and np.any(stood & ~np.isfinite(again)):
            for i, k in np.argwhere(stood & ~np.isfinite(again)):
                axis.plot(
                    np.radians(offset) + i * width, _HUB + (k + 0.5) * height, "x", color="black", ms=5.0, zorder=4
                )
            marks.append(
                Line2D([], [], color="black", marker="x", ls="", label="upright, but never calm, or the legs touched")
            )
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


def _label(axis: PolarAxes, n_directions: int, offset: float) -> None:
    """Forward is up and left is left, as seen from above."""
    axis.set_theta_zero_location("N")
    axis.set_ylim(0.0, 1.0)
    axis.grid(visible=False)
    axis.spines["polar"].set_visible(False)
    names = {0: "forward", 90: "left", 180: "back", 270: "right"}
    degrees = ((offset + np.arange(n_directions) * 360.0 / n_directions) % 360.0).tolist()
    axis.set_xticks(np.radians(degrees).tolist(), [names.get(round(angle, 6), f"{angle:g}°") for angle in degrees])
    axis.set_yticks([])
    axis.text(0.0, 0.0, "phase of\nthe stride\ninside 0,\noutside 1", ha="center", va="center", fontsize=9.0)
