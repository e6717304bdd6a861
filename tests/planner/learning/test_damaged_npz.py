"""Tests of damaged .npz files: each is refused in one line, whatever NumPy raises."""

import io
from zipfile import ZipFile

import numpy as np
import pytest

from planner.learning.files import read_npz


@pytest.mark.parametrize(
    "header",
    ["{'descr': '<f8', 'fortran_order': False, 'shape': (3,", "(", "{'a': \x00", "]", '"""', ""],
)
def test_an_array_whose_header_is_no_python_is_refused_in_one_line(tmp_path, header):
    whole = io.BytesIO()
    np.save(whole, np.arange(3.0))
    size = int.from_bytes(whole.getvalue()[8:10], "little")
    packed = whole.getvalue()[:10] + header.encode().ljust(size - 1) + b"\n"
    path = tmp_path / "a.npz"
    with ZipFile(path, "w") as file:
        file.writestr("a.npy", packed + whole.getvalue()[10 + size :])
    with pytest.raises(ValueError, match=r"^[^\n]+"):
        read_npz(path, 10_000)
