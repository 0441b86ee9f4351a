"""What lies inside something else at home does not collide with it; everything else does."""

from __future__ import annotations

import mujoco

from gaitsmith.robots.overlaps import exclude_overlaps

MODEL = """<mujoco><worldbody><body name="torso"><freejoint/><geom type="box" size=".1 .1 .1"/>
<body name="arm" pos="0 .3 0"><joint name="arm" axis="0 0 1" range="-3 3"/><geom type="box" size=".05 .05 .05"/>
<body name="hand" pos="0 .25 0"><joint name="hand" axis="1 0 0" range="-3 3"/>
<geom type="box" size=".05 .05 .05"/></body></body>
<body name="l" pos=".03 0 -1"><joint name="l" axis="0 1 0" range="-1 1"/><geom type="box" size=".05 .05 .02"/></body>
<body name="r" pos="-.03 0 -1"><joint name="r" axis="0 1 0" range="-1 1"/><geom type="box" size=".05 .05 .02"/></body>
</body></worldbody></mujoco>"""


def excluded(home: dict[str, float], feet: set[str]) -> tuple[list[tuple[str, str]], list[str]]:
    spec, notes = mujoco.MjSpec.from_string(MODEL), list[str]()
    found = exclude_overlaps(spec, spec.compile(), home, feet, notes)
    pairs = [(exclude.bodyname1, exclude.bodyname2) for exclude in spec.excludes]
    assert found == bool(pairs) == bool(notes)
    return pairs, notes


def test_nothing_is_excluded_where_nothing_overlaps() -> None:
    assert excluded({}, {"l", "r"}) == ([], [])


def test_what_overlaps_at_home_is_excluded_and_named() -> None:
    pairs, notes = excluded({"arm": 3.0}, {"l", "r"})
    assert pairs == [("torso", "hand")]
    assert "torso and hand" in notes[0]


def test_feet_still_collide() -> None:
    assert excluded({}, set())[0] == [("l", "r")]
    assert excluded({}, {"l", "r"})[0] == []
