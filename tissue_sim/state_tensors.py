"""A world's whole state as tensors, and back, exactly: what a saved trajectory holds.

Arrays become tensors of the same type with a batch of one in front; the rest (the record of clips,
cuts and injuries, the anatomy) becomes bytes.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterator
from dataclasses import is_dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

REST = "rest"
BLOCK_BYTES = 32768  # the rest is padded to a multiple of it, so that states can be stacked
_NUMPY = {"_reconstruct", "ndarray", "dtype", "scalar", "_frombuffer"}


def state_to_tensors(state: dict[str, Any]) -> dict[str, torch.Tensor]:
    """Nested dicts and tuples to one flat dict, keyed by path."""
    tensors = {path: torch.from_numpy(a.copy())[None] for path, a in _arrays(state, "")}
    data = pickle.dumps(_without_arrays(state))
    data = data.ljust(-(-len(data) // BLOCK_BYTES) * BLOCK_BYTES, b"\0")
    tensors[REST] = torch.from_numpy(np.frombuffer(data, np.uint8).copy())[None]
    return tensors


def state_from_tensors(tensors: dict[str, Any]) -> dict[str, Any]:
    """What `state_to_tensors` was given.

    Raises:
        ValueError: a tensor is missing, or the rest holds what no state holds.
    """
    if REST not in tensors:
        raise ValueError(f"state: {REST!r} is missing; it has {sorted(tensors)}")
    data = _array(tensors[REST]).tobytes()
    try:
        skeleton = _Unpickler(io.BytesIO(data)).load()
    except (pickle.UnpicklingError, EOFError) as error:
        raise ValueError(f"state: {REST!r} is not a world's: {error}") from error
    return _filled(skeleton, tensors, "")


class _Unpickler(pickle.Unpickler):
    """Reads this project's data classes and numbers, and calls nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        found = None
        if module.startswith("tissue_sim.") or (module.split(".")[0] == "numpy" and name in _NUMPY):
            found = super().find_class(module, name)
        if found is None or not (is_dataclass(found) or name in _NUMPY):
            if (module, name) == ("builtins", "frozenset"):
                return frozenset
            raise ValueError(f"state: it holds {module}.{name}, which no state of a world does")
        return found


def _arrays(node: Any, path: str) -> Iterator[tuple[str, NDArray[Any]]]:
    if isinstance(node, np.ndarray):
        yield path, node
    for key, child in _children(node):
        yield from _arrays(child, f"{path}/{key}" if path else str(key))


def _children(node: Any) -> Iterator[tuple[Any, Any]]:
    if isinstance(node, dict):
        yield from node.items()
    elif isinstance(node, tuple):
        yield from enumerate(node)


def _without_arrays(node: Any) -> Any:
    """The same with None for each array."""
    if isinstance(node, np.ndarray):
        return None
    if isinstance(node, dict):
        return {k: _without_arrays(v) for k, v in node.items()}
    return tuple(_without_arrays(v) for v in node) if isinstance(node, tuple) else node


def _filled(node: Any, tensors: dict[str, Any], path: str) -> Any:
    if path and path in tensors:
        return _array(tensors[path])
    if node is None:
        raise ValueError(f"state: {path!r} is missing")
    if isinstance(node, dict):
        return {k: _filled(v, tensors, f"{path}/{k}" if path else str(k)) for k, v in node.items()}
    if isinstance(node, tuple):
        return tuple(_filled(v, tensors, f"{path}/{i}") for i, v in enumerate(node))
    return node


def _array(tensor: Any) -> NDArray[Any]:
    return torch.as_tensor(tensor)[0].numpy().copy()
