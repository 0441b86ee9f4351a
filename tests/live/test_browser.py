"""The page in a real browser, without a screen: it loads, the robot moves, and what is clicked and typed happens."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import pytest

from gaitsmith.live.replay import Replay
from gaitsmith.live.run import Run

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine: apt install chromium")
SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
PATIENCE = 120_000  # ms: a browser that draws without a graphics card, on a busy machine
SPEED = """() => { const charts = Object.values(window.__viserTestpoints?.uplots ?? {});
    return charts.length ? charts[0].chart.data[4].at(-1) : 0.0; }"""  # mean of a step


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="the tests need playwright: pip install '.[dev]'")
    with playwright.sync_playwright() as running:
        made = running.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE)
        yield made
        made.close()


@pytest.fixture(scope="module")
def tab(browser, steered):
    page = browser.new_page(viewport={"width": 1000, "height": 560}, device_scale_factor=0.5)
    page.set_default_timeout(PATIENCE)
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    page.add_init_script("window.pad = null; navigator.getGamepads = () => [window.pad];")
    page.goto(steered.address)
    page.get_by_text("Walking", exact=True).wait_for()
    return page


@pytest.fixture(scope="module")
def pictures(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("pictures")


def until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def speed_field(page):
    """The number beside the first slider."""
    return page.locator("input[inputmode=decimal]").first


def test_it_loads_and_the_robot_moves(tab, steered, pictures):
    before, at = tab.screenshot(path=pictures / "walking.png", timeout=PATIENCE), steered.page.frame["live.time"]
    until(lambda: steered.page.frame["live.time"] > at + 0.5)
    assert tab.screenshot(timeout=PATIENCE) != before
    assert tab.errors == []


def test_a_speed_that_is_typed_is_walked_and_the_chart_follows(tab, steered):
    speed = speed_field(tab)
    speed.fill("0.5")
    speed.press("Enter")
    until(lambda: steered.page.frame["command.speed_x"] == 0.5)
    tab.wait_for_function(f"() => Math.abs(({SPEED})() - 0.5) < 0.03", timeout=PATIENCE)


def test_keys_turn_it_and_stop_it(tab, steered):
    tab.evaluate("document.activeElement.blur()")  # keys are for what is typed while a number has the focus
    yaw = steered.page.frame["true.torso_yaw"]
    for _ in range(4):
        tab.keyboard.press("a")
    until(lambda: steered.page.frame["command.yaw_rate"] > 0.2)
    until(lambda: abs(steered.page.frame["true.torso_yaw"] - yaw) > 0.1)
    tab.keyboard.press("x")
    until(lambda: steered.page.frame["command.yaw_rate"] == steered.page.frame["command.speed_x"] == 0.0)


def test_a_gamepad_presses_the_page_s_keys(tab, steered):
    tab.evaluate("window.pad = { axes: [0.0, -1.0, 0.9], buttons: [] }")
    until(lambda: steered.page.controls.gait["speed_x"] > 0.1 and steered.page.controls.gait["yaw_rate"] < -0.1)
    tab.evaluate("window.pad = { axes: [], buttons: [{}, { pressed: true }] }")
    until(lambda: steered.page.frame["command.yaw_rate"] == steered.page.frame["command.speed_x"] == 0.0)
    tab.evaluate("window.pad = null")


def test_a_push_is_survived(tab, steered):
    pushed = []
    tab.get_by_text("←", exact=True).click()
    until(lambda: steered.page.scene._pushed[0] > 0.0)
    pushed.append(steered.page.frame["live.time"])
    until(lambda: steered.page.frame["live.time"] > pushed[0] + 2.0)
    assert steered.page.frame["live.over"] == 0.0


def test_it_pauses_and_goes_on_slowly(tab, steered):
    tab.get_by_text("⅕", exact=True).click()
    until(lambda: steered.page.frame["live.factor"] == 0.2)
    tab.keyboard.press("Space")
    tab.get_by_text("Paused", exact=True).wait_for()
    at = steered.page.frame["live.time"]
    time.sleep(0.3)
    assert steered.page.frame["live.time"] == at
    tab.get_by_text("One tick", exact=True).click()
    until(lambda: steered.page.frame["live.time"] == pytest.approx(at + 0.001))
    tab.get_by_text("Pause", exact=True).click()
    until(lambda: steered.page.frame["live.time"] > at + 0.1)
    tab.get_by_text("1×", exact=True).click()


def test_a_second_tab_and_a_reload_show_the_same_gait(tab, browser, steered):
    second = browser.new_page(viewport={"width": 600, "height": 300}, device_scale_factor=0.3)
    second.goto(steered.address)
    second.get_by_text("Walking", exact=True).wait_for(timeout=PATIENCE)
    second.close()
    tab.reload()
    tab.get_by_text("Walking", exact=True).wait_for()
    assert float(speed_field(tab).input_value()) == 0.0
    assert steered.page.frame["live.over"] == 0.0
    tab.close()


def test_the_replay_of_a_fall_marks_it_and_says_why(browser, pictures, fallen):
    replay = Replay(Run(str(fallen)), "127.0.0.1", 0)
    tab = browser.new_page(viewport={"width": 1000, "height": 560}, device_scale_factor=0.5)
    tab.set_default_timeout(PATIENCE)
    tab.goto(replay.address)
    tab.get_by_text("event ▶", exact=True).wait_for()
    replay.playing = False
    for _ in range(2):  # the push, then the fall
        at = replay.at
        tab.get_by_text("event ▶", exact=True).click()
        until(lambda at=at: replay.at > at)
    replay.at = replay._end
    replay.update(0.0)
    tab.get_by_text(f"Fell at {replay._run.fall.time:.2f} s").wait_for()
    assert tab.locator("svg rect title").count() >= 1
    tab.screenshot(path=pictures / "fall.png", timeout=PATIENCE)
    tab.close()
    replay.close()
