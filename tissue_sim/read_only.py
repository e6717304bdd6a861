"""Make the arrays of messages read-only, because several readers share each message."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)


def read_only(array: NDArray[Number]) -> NDArray[Number]:
    """Return a read-only view of an array; the array's owner can still write."""
    view = array.view()
    view.flags.writeable = False
    return view


def seal(message: object) -> None:
    """Make the arrays in a frozen message read-only, including arrays in its dicts.

    Call `seal` when a message is made, and when a message is copied or unpickled.
    """
    fields = vars(message)
    for name, value in fields.items():
        if isinstance(value, np.ndarray) and value.flags.writeable:
            fields[name] = read_only(value)
        elif isinstance(value, dict):
            fields[name] = {key: read_only(array) for key, array in value.items()}
