"""Policies as ONNX files that say what they were made for; the smallest kind, a perceptron, in NumPy."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.files import write_bytes_atomic
from gaitsmith.simulation.step_policy import KEY, PolicyCard

_OPSET = 17
_IR_VERSION = 9  # of the file format; every ONNX Runtime of the last years reads it


@dataclass(frozen=True)
class Perceptron:
    """tanh(W₂ tanh(W₁ s + b₁) + b₂).

    Attributes:
        card: what it was made for.
        weights: W₁ (h, n), b₁ (h,), W₂ (m, h), b₂ (m,).
    """

    card: PolicyCard
    weights: tuple[npt.NDArray[np.float64], ...]

    @staticmethod
    def size(card: PolicyCard, hidden: int) -> int:
        """Numbers that make one."""
        n, m = len(card.seen), len(card.adjusted)
        return hidden * (n + 1) + m * (hidden + 1)

    @classmethod
    def of(cls, card: PolicyCard, hidden: int, numbers: npt.ArrayLike) -> Perceptron:
        """One made of (:meth:`size`,) numbers.

        Raises:
            BadInput: another count of numbers.
        """
        flat = np.asarray(numbers, dtype=np.float64)
        if flat.shape != (cls.size(card, hidden),):
            raise BadInput("numbers", flat.shape, f"({cls.size(card, hidden)},)")
        n, m = len(card.seen), len(card.adjusted)
        parts = np.split(flat, np.cumsum([hidden * n, hidden, m * hidden]))
        return cls(card, (parts[0].reshape(hidden, n), parts[1], parts[2].reshape(m, hidden), parts[3]))

    def act(self, seen: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """From what is seen (n,) to adjustments (m,), -1 to 1."""
        first, offset, second, bias = self.weights
        return np.tanh(second @ np.tanh(first @ seen + offset) + bias)


def write_policy(path: str | Path, policy: Perceptron) -> None:
    """Write a policy for ``gaitsmith walk --policy``, its joints, inputs and ranges as metadata.

    Raises:
        BadInput: the file cannot be written, or ONNX is not installed.
    """
    try:
        from onnx import TensorProto, helper, numpy_helper
    except ImportError:
        raise BadInput("onnx", "not installed", "the extra policy", "pip install 'gaitsmith[policy]'") from None
    card = policy.card
    names = ("first", "offset", "second", "bias")
    tensors = [
        numpy_helper.from_array(np.ascontiguousarray(array.T, dtype=np.float32), name)
        for name, array in zip(names, policy.weights, strict=True)
    ]
    nodes = [
        helper.make_node("MatMul", ["seen", "first"], ["a"]),
        helper.make_node("Add", ["a", "offset"], ["b"]),
        helper.make_node("Tanh", ["b"], ["c"]),
        helper.make_node("MatMul", ["c", "second"], ["d"]),
        helper.make_node("Add", ["d", "bias"], ["e"]),
        helper.make_node("Tanh", ["e"], ["adjusted"]),
    ]
    ends = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["steps", width])
        for name, width in (("seen", len(card.seen)), ("adjusted", len(card.adjusted)))
    ]
    graph = helper.make_graph(nodes, "step policy", ends[:1], ends[1:], tensors)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR_VERSION)
    helper.set_model_props(model, {KEY: json.dumps(card.model_dump(mode="json"), allow_nan=False)})
    write_bytes_atomic(Path(path), model.SerializeToString())
