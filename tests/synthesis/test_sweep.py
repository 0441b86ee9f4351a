"""A row of the sweep: what is beyond reach is not tried, neighbours start warm, physics certifies what is solved."""

from gaitsmith.synthesis.requests.sweep import REACH, sweep_document, sweep_row


def test_a_row_is_solved_from_neighbour_to_neighbour():
    cells = sweep_row("thbip_ii", 0.35, (0.5, 0.55, 1.0))
    assert [cell.status for cell in cells] == ["certified", "certified", "beyond reach"]
    assert cells[2].length > REACH
    assert cells[2].iterations == 0
    assert cells[1].iterations < cells[0].iterations
    assert min(cell.zmp_margin_mm for cell in cells[:2]) >= 10.0 - 0.1
    document = sweep_document(cells)
    assert (document["reachable"], document["certified"], document["status"]) == (2, 2, "solved")
