"""Numbers are found by name, and the views are the buffers."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.log.columns import Columns


def test_names_lead_to_views() -> None:
    told, true = np.arange(4.0), np.arange(10.0, 13.0)
    columns = Columns((("time", "torque.a", "torque.b", "torque_limit"), told), (("true.x", "true.y", "true.z"), true))
    torque = columns.find("torque")
    assert torque is not None
    assert torque.tolist() == [1.0, 2.0]
    told[2] = 7.0
    assert torque[1] == 7.0
    assert columns.block(["true.y", "true.z"]).tolist() == [11.0, 12.0]
    assert columns.labels("torque") == ("a", "b")
    assert columns.find("speed") is None
    for names in (["speed"], ["true.x", "true.z"], ["torque.b", "true.x"]):
        with pytest.raises(KeyError):
            columns.block(names)
