"""Figure 5 and a ring of pushes in two physics engines, the paper's own one beside the usual one."""

from __future__ import annotations

from gaitsmith.errors import BadInput
from gaitsmith.experiments.push_grid import SURVIVAL, PushGrid, survival_time, survived
from gaitsmith.reports.run import make_run
from gaitsmith.reproduction import template_figures as draw
from gaitsmith.reproduction.finding import Found, Tell
from gaitsmith.simulation.engines import engine_of
from gaitsmith.simulation.episode import run_episode
from gaitsmith.simulation.scenario import load_scenario, make_scenario
from gaitsmith.view.push_map import draw_push_map

_IMPULSE = 15.0  # N·s
_SMALL_SPEED = 0.02  # m/s
_LEAST = 0.9  # of all pushes
_ENGINES = {"mujoco": "MuJoCo", "bullet": "Bullet"}
_FIGURE, _SAYS = "template5", "the simulation was done in Bullet: there the robot walks the same profile"


def engines(found: Found, tell: Tell) -> None:
    """Walk the profile of Fig. 5 in Bullet, and push the robot from all sides in both engines."""
    try:
        engine_of("bullet")
        _profile(found, tell)
    except BadInput as error:
        if error.field != "engine":
            raise
        found.say(_FIGURE, _SAYS, "the package pybullet is not there", None, error.remedy)
        return
    stood = {engine: _pushes(engine, found, tell) for engine in _ENGINES}
    found.say(
        _FIGURE,
        "what holds in one engine holds in the other (not the paper's: both are shown)",
        "; ".join(f"{name}: {stood[engine]} of 8 pushes of {_IMPULSE:g} N·s" for engine, name in _ENGINES.items()),
        min(stood.values()) >= _LEAST * 8,
        f"fewer than {_LEAST:.0%} are survived",
    )


def _profile(found: Found, tell: Tell) -> None:
    scenario = load_scenario("figure5").model_copy(update={"engine": "bullet"})
    run = make_run(
        scenario,
        found.folder / "figure5-bullet",
        lambda t: tell(f"figure5, Bullet: {t:.0f} of {scenario.duration:.0f} s"),
    )
    title = "Fig. 5 in Bullet: walking under different reference speeds"
    found.draw(_FIGURE, draw.speed_and_attitude(run.recording, title), "in Bullet", "template5-bullet")
    stages = [stage for stage in run.summary.stages if not stage.rest]
    worst, top = max(abs(stage.vx_error) for stage in stages), max(stage.command.vx for stage in stages)
    how = f"fell at {run.summary.fall.time:.1f} s" if run.summary.fall else "upright to the end"
    found.say(
        _FIGURE,
        _SAYS,
        f"{how}, to {top:.1f} m/s; mean of a stage off by at most {1e3 * worst:.1f} mm/s",
        not run.summary.fell and worst < _SMALL_SPEED and top >= 0.7,
        f"the limit is {1e3 * _SMALL_SPEED:.0f} mm/s",
    )


def _pushes(engine: str, found: Found, tell: Tell) -> int:
    """How many pushes are survived, in place."""
    base = make_scenario({"engine": engine, "speed": [0.0, 0.0], "period": 0.4, "height": 0.70})
    grid, stood, seconds = PushGrid(_IMPULSE, base, directions=8, phases=1), 0, []
    for number, cell in enumerate(grid.cells):
        tell(f"pushes, {_ENGINES[engine]}: {number} of {len(grid.cells)}")
        summary = run_episode(grid.scenario(cell), record=False).summary
        stood += survived(summary)
        seconds.append([survival_time(summary)])
    title = f"{_IMPULSE:g} N·s in place, {_ENGINES[engine]}"
    found.draw(
        _FIGURE, draw_push_map(title, seconds, SURVIVAL), f"pushes, {_ENGINES[engine]}", f"template5-pushes-{engine}"
    )
    return stood
