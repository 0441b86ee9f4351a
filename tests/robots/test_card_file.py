from __future__ import annotations

from pathlib import Path

import pytest
from tests.robots.samples import BHR, card_data

from gaitsmith.errors import BadInput
from gaitsmith.robots.card_file import parse_card, read_card


def test_reads_the_shipped_card() -> None:
    card, content = read_card(BHR / "card.toml")
    assert card == parse_card(card_data())
    assert content == (BHR / "card.toml").read_bytes()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"legs = 3",
        b"schema_version = ",
        b"\xff\xfe",
        b"a = [" * 20_000,
        b"a = " + b"9" * 10_000,
        b"a = 2020-01-01",
        b"presets = { default = 1 }",
        b"mass = nan",
        b"x." * 5000 + b"x = 1",
    ],
)
def test_refuses_other_content_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "card.toml"
    path.write_bytes(content)
    with pytest.raises(BadInput) as caught:
        read_card(path)
    assert "card.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_card_of_version_1_keeps_all_but_its_presets() -> None:
    now = card_data()
    old = now | {"schema_version": 1, "presets": {"default": {"foothold": {"integral_gain": [0.12, 0.03]}}}}
    card = parse_card(old)
    assert card.presets.keys() == {"default"}
    assert card.presets["default"].model_dump(exclude_none=True) == {}
    kept = parse_card(now).model_dump(exclude={"presets", "schema_version"})
    assert card.model_dump(exclude={"presets", "schema_version"}) == kept
