"""Figures of a planned gait are drawn, each as a whole PNG."""

from gaitsmith.view.gait_figures import write_gait_figures


def test_every_figure_is_drawn(dynamic, robot, tmp_path):
    paths = write_gait_figures(dynamic.gait, robot, tmp_path / "figures")
    assert [path.name for path in paths] == ["sticks.png", "joints.png", "ground.png", "reactions.png"]
    for path in paths:
        content = path.read_bytes()
        assert content.startswith(b"\x89PNG")
        assert content.endswith(b"IEND\xaeB`\x82")
        assert path.with_suffix(".svg").read_text().count("m/s, step") == 1  # what it was planned for
