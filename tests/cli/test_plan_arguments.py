"""Every flag means something for what is planned, or is refused by name."""

import math
from pathlib import Path

import pytest

from gaitsmith.cli import main
from gaitsmith.cli.arguments import parse
from gaitsmith.cli.plan_arguments import FILE, PlanArguments, request_from, task_of
from gaitsmith.errors import BadInput
from gaitsmith.synthesis.files.gait_file import LIMIT
from gaitsmith.synthesis.motions.parameters import KickParameters, StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.requests.asked import KICK_FRICTION, KINDS, MOST_CYCLES, Request

VALUES = {
    "--speed": "0.3",
    "--step-length": "0.15",
    "--period": "0.5",
    "--step-height": "0.05",
    "--double-support": "0.2",
    "--order": "4",
    "--cycles": "3",
    "--zmp-margin": "0.01",
    "--friction": "0.5",
    "--max-iterations": "9",
    "--free-times": "",
    "--ball": "0.04 0.07",
    "--kick-height": "0.05",
    "--x-max": "0.16",
    "--rise": "0.04",
    "--tread": "0.22",
    "--steps": "4",
    "--slope": "-3",
    "--jobs": "2",
    "--out": "g.json",
    "--figures": "figures",
}
WALKS = {"--free-times", "--slope", "--speed", "--step-length", "--period", "--step-height", "--double-support"}
SOLVE = {"--order", "--zmp-margin", "--friction", "--max-iterations", "--out", "--figures"}
MEANT = {
    **dict.fromkeys(("cyclic", "start", "stop"), WALKS | SOLVE),
    "walk": WALKS | SOLVE | {"--cycles"},
    "kick": {"--speed", "--ball", "--kick-height", "--x-max"} | SOLVE,
    "stairs": {"--rise", "--tread", "--steps", "--period", "--step-height", "--double-support"} | SOLVE,
    "sweep": {"--jobs"},
    "--claims": set(),
    "m.toml": {"--out", "--figures"},
}


def arguments_of(*words: str) -> PlanArguments:
    return parse(PlanArguments, words, "gaitsmith plan")


@pytest.mark.parametrize("task", MEANT)
@pytest.mark.parametrize("flag", VALUES)
def test_a_flag_applies_or_is_refused(task: str, flag: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.toml").write_text("")
    arguments = arguments_of(task, flag, *VALUES[flag].split())
    if flag in MEANT[task]:
        assert task_of(arguments) == (FILE if task == "m.toml" else task)
    else:
        with pytest.raises(BadInput) as caught:
            task_of(arguments)
        assert caught.value.field == flag
        assert "for " in caught.value.remedy


@pytest.mark.parametrize("words", [["m.toml"], ["cyclic"], ["kick"]])
def test_claims_take_no_motion(words: list[str]) -> None:
    with pytest.raises(BadInput, match="--claims"):
        task_of(arguments_of("--claims", *words))


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_given_asks_for_the_defaults(kind: str) -> None:
    request = request_from(arguments_of(kind), kind)
    assert request is not None
    friction = KICK_FRICTION if kind == "kick" else Settings().bounds.friction
    assert request.settings.bounds.friction == friction
    assert request.settings.model_copy(update={"bounds": Settings().bounds}) == Settings()
    own = {
        "stairs": (StepParameters(0.2, 1.2, height=0.03, rise=0.05), 2),
        "turn": (StepParameters(0.0, 1.0, turn=math.radians(15.0)), 2),  # on the spot; 2 steps between start and stop
    }
    assert (request.step, request.cycles) == own.get(kind, (StepParameters(0.15, 1.0), Request.cycles))


def test_flags_reach_the_request() -> None:
    words = "walk --speed 0.4 --period 0.5 --step-height 0.05 --double-support 0.2 --cycles 3 --zmp-margin 0.01"
    request = request_from(
        arguments_of(*words.split(), "--friction", "0.5", "--order", "4", "--max-iterations", "9"), "walk"
    )
    assert request is not None
    assert request.step == StepParameters(0.2, 0.5, 0.05, 0.2)
    assert request.cycles == 3
    settings = request.settings
    assert (settings.order, settings.max_iterations) == (4, 9)
    assert (settings.bounds.friction, settings.bounds.zmp_margin) == (0.5, 0.01)


def test_a_kick_has_flags_for_its_ball_height_and_reach() -> None:
    words = "kick --ball 0.04 0.07 --kick-height 0.05 --x-max 0.16"
    request = request_from(arguments_of(*words.split()), "kick")
    assert request is not None
    assert request.kick == KickParameters(ball=(0.04, 0.07), height=0.05, reach=0.16)


@pytest.mark.parametrize(
    ("words", "flags"),
    [
        (["walk", "--cycles", str(MOST_CYCLES + 1)], ["--cycles"]),
        (["cyclic", "--speed", "0.01", "--step-length", "1"], ["--speed", "--step-length"]),
        (["cyclic", "--speed", "2", "--period", "10"], ["--speed", "--period"]),
        (["kick", "--speed", "50"], ["--speed"]),
        (["cyclic", "--zmp-margin", "-0.01"], ["--zmp-margin"]),
        (["cyclic", "--out", ""], ["--out"]),
    ],
)
def test_ranges(words: list[str], flags: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", *words]) == 2
    told = capsys.readouterr().err
    assert len(told.splitlines()) == 1
    assert all(flag in told for flag in flags)


def test_help_shows_the_real_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", "cyclic", "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "[MOTION]" in shown
    assert "scenario" not in shown
    bounds = Settings().bounds
    for part in (
        f"(default: {bounds.friction:g}, for a kick {KICK_FRICTION:g}, above 0 up to 5)",
        f"(default: {bounds.zmp_margin:g}, from 0 to 1)",
        f"(default: {StepParameters.height:g}, from 0.005 to 0.3)",
        f"(default: {StepParameters.double_support:g}, from 0.05 to 0.8)",
        f"(default: {Request.cycles}, from 0 to {MOST_CYCLES})",
    ):
        assert part in shown
    for command in ("verify", "export"):
        assert main([command, "--help"]) == 0
        assert "scenario" not in capsys.readouterr().out


def test_the_longest_walk_can_be_read_back() -> None:
    assert MOST_CYCLES * 190_000 < LIMIT  # bytes of a cycle, found by writing walks
    with pytest.raises(BadInput, match="--cycles"):
        Request("walk", cycles=MOST_CYCLES + 1)
