"""A page is whole in itself, and what it is given is text, never markup."""

import re

from gaitsmith.reports.page import Page
from gaitsmith.view.canvas import figure

HOSTILE = '<script>alert("x")</script> & "quoted"'


def test_whatever_is_written_is_text() -> None:
    page = Page(HOSTILE, HOSTILE)
    page.heading(HOSTILE, anchor=HOSTILE)
    page.text(HOSTILE)
    page.code(HOSTILE)
    page.table((HOSTILE,), [(HOSTILE,)])
    page.picture(b"", "image/png", HOSTILE)
    assert "<script" not in page.render()
    assert (
        page.render().count("&lt;script&gt;") == 11
    )  # the title and a picture's caption twice, the heading's anchor too


def test_pictures_are_inside_and_nothing_is_fetched() -> None:
    page = Page("figures")
    with figure("one", 2.0) as made:
        made.subplots().plot([0, 1])
    page.figure(made, "a line")
    page.versions()
    text = page.render()
    assert text.count('src="data:image/svg+xml;base64,') == 1
    assert not re.findall(r'(?:src|href)="(?!data:)', text)
    assert "default-src 'none'" in text
    assert "mujoco" in text


def test_verdicts_are_coloured_and_numbers_are_not() -> None:
    page = Page("verdicts")
    page.table(("claim", "verdict"), [("speed", "agrees"), ("yaw", "differs: less torque")], left=(0, 1))
    assert '<td class="good">agrees</td>' in page.render()
    assert '<td class="bad">differs: less torque</td>' in page.render()
