"""Rows of numbers as a CSV file."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gaitsmith.files import replacing


def write_table(path: Path, columns: Sequence[str], blocks: Iterable[npt.NDArray[np.float64]]) -> None:
    """One line of names, one line a row of the (n, m) blocks; numbers read back to the last bit.

    Raises:
        BadInput: the file cannot be written.
    """
    with replacing(path) as file:
        text = io.TextIOWrapper(io.BufferedWriter(file), encoding="utf-8", newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        for block in blocks:
            writer.writerows(block.tolist())
        text.flush()
        text.detach().detach()
