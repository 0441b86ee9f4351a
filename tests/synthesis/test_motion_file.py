"""Motion files: what is read, and what is refused in one line that names the entry."""

from pathlib import Path

import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.files.motion_file import PHASES, SECTIONS, read_motion
from gaitsmith.synthesis.motions.motion import Limit, Same, State

EXAMPLE = Path(__file__).parents[2] / "examples" / "motions" / "obstacle.toml"
FLAT = """[[phases]]
name = "a"
duration = 0.6
support = "right"
contact = "flat"
support_at = [0.0, -0.065]
other_at = [0.0, 0.065]
"""
AIR = FLAT.replace('"a"', '"b"').replace('"flat"', '"air"').replace("other_at = [0.0, 0.065]\n", "")
REST = "[[conditions]]\nstanding = true\n"


@pytest.fixture(scope="module")
def biped(planner):
    return planner.biped


def _read(tmp_path, biped, text):
    file = tmp_path / "own.toml"
    file.write_text(text)
    return read_motion(file, biped)


def test_the_example_is_read(biped):
    motion, settings = read_motion(EXAMPLE, biped)
    assert len(motion.phases) == 10
    assert motion.phases[1].limits == (Limit("toe_x", high=0.11),)
    assert [type(item) for item in motion.conditions] == [State, State]
    assert settings.bounds.foot_gap == 0.01


def test_an_instant_may_be_that_of_another(tmp_path, biped):
    text = 'name = "own"\n' + FLAT + AIR + '[[conditions]]\nafter = "b"\nsame_as = "a"\n'
    assert _read(tmp_path, biped, text)[0].conditions == (Same(2, 1),)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("duration = 0.6", 'duration = "0.6"', r"phases\[0\].duration: got '0.6', expected .* from 0.02 to 60"),
        ("duration = 0.6", "duration = true", r"phases\[0\].duration: got True"),
        ("duration = 0.6", "duration = nan", r"phases\[0\].duration"),
        ("duration = 0.6", f"duration = 1{'0' * 400}", r"phases\[0\].duration"),
        ("duration = 0.6", "duration = 2020-01-01", r"phases\[0\].duration"),
        ("duration = 0.6\n", "", r"phases\[0\].duration: got nothing, expected .* from 0.02 to 60"),
        ("duration = 0.6", "duration = 0.6\nspeed = 1", r"phases\[0\].speed: .*only name, duration"),
        ('"flat"', '"flying"', r"phases\[0\].contact: got 'flying', expected one of air, flat"),
        ("[0.0, 0.065]", "[0.0, 0.065, 1.0]", r"phases\[0\].other_at: .* a list of 2 numbers"),
        ("[0.0, 0.065]", '[0.0, "a"]', r"phases\[0\].other_at\[1\]: got 'a', expected a finite number"),
        ("[0.0, 0.065]", "[0.0, -0.065]", r"phases\[0\].other_at: .*at least"),
        ("[0.0, 0.065]", "[0.3, -0.3]", r"phases\[0\].other_at: .*left sole"),
        ("other_at = [0.0, 0.065]\n", "", r"phases\[0\].other_at: got nothing"),
        ("duration", "sections = 2.5\nduration", r"phases\[0\].sections: .*whole number from 1 to 20"),
        ("duration", "limits = { toe_z = {} }\nduration", r"phases\[0\].limits.toe_z: got {}, expected .*at least one"),
        ("duration", "limits = { toe = { min = 0.1 } }\nduration", r"phases\[0\].limits.toe: .*one of ankle_x"),
        ("duration", "limits = { toe_z = { min = '1' } }\nduration", r"limits.toe_z.min: .* finite number"),
        ("duration", "limits = { toe_z = { min = 2, max = 1 } }\nduration", r"limits.toe_z: .*not above the upper"),
        ('name = "own"', 'name = "own"\ncyclic = 1', "cyclic: got 1, expected true or false"),
        ('name = "own"', 'name = "own walk"', "name: got 'own walk', expected 1 to 40 letters, digits, - and _"),
        ('name = "own"', 'name = "own"\nstanding_height = 9', "standing_height"),
        ("standing = true", 'standing = "yes"', r"conditions\[0\].standing: got 'yes', expected true or false"),
        ("standing = true", "", r"conditions\[0\].*standing, rest, steady, same_as, unloaded, values or joints"),
        ("standing = true", 'after = "a"\nsame_as = "a"', r"conditions\[0\].same_as"),
        ("standing = true", "values = { toe = 1.0 }", r"conditions\[0\].values.toe"),
        (REST, "[settings.bounds]\nfriction = 9\n", "settings.bounds.friction: got 9, .*up to 5"),
        (REST, "[settings.bounds]\nfrictions = 1\n", "settings.bounds.frictions: .*only friction"),
        (REST, "[settings]\norder = 6\n", "settings.order: got 6, expected one of 4, 5"),
    ],
)
def test_refusals_name_the_entry(tmp_path, biped, old, new, words):
    text = 'name = "own"\n' + FLAT + REST
    assert old in text
    with pytest.raises(BadInput, match=words) as refused:
        _read(tmp_path, biped, text.replace(old, new))
    assert str(refused.value).startswith("own.toml: ")


def test_size_is_limited(tmp_path, biped):
    many = "".join(FLAT.replace('"a"', f'"a{k}"') for k in range(PHASES + 1))
    with pytest.raises(BadInput, match=f"phases.*1 to {PHASES}"):
        _read(tmp_path, biped, 'name = "own"\n' + many)
    full = "".join(FLAT.replace('"a"', f'"a{k}"').replace("duration", "sections = 20\nduration") for k in range(7))
    with pytest.raises(BadInput, match=f"140 sections.*{SECTIONS}"):
        _read(tmp_path, biped, 'name = "own"\n' + full)


@pytest.mark.parametrize("text", ["", "name = 1", "not toml", "a = " + "[" * 3000, "\x00"])
def test_what_is_no_motion_is_refused(tmp_path, biped, text):
    with pytest.raises(BadInput, match=r"own\.toml"):
        _read(tmp_path, biped, text)
