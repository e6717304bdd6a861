"""Messages whose arrays nobody can write into, as several people read the same one."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)


def read_only(array: NDArray[Number]) -> NDArray[Number]:
    """Return a view that cannot be written into; its owner still can write into the array."""
    view = array.view()
    view.flags.writeable = False
    return view


def seal(message: object) -> None:
    """Make the arrays in a frozen message read-only, also those in its dicts.

    Call it when the message is made, and when it is made from a copy or a pickle.
    """
    fields = vars(message)
    for name, value in fields.items():
        if isinstance(value, np.ndarray) and value.flags.writeable:
            fields[name] = read_only(value)
        elif isinstance(value, dict):
            fields[name] = {key: read_only(array) for key, array in value.items()}
