"""Convert a world's whole state to tensors and back, exactly, for saved trajectories.

Arrays become tensors of the same type with a batch axis of one in front. The rest (the record of
clips, cuts and injuries, the anatomy) becomes the bytes of a JSON text.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import is_dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tissue_sim.patient.anatomy import Anatomy, Artery
from tissue_sim.structures.tubes import Crossing
from tissue_sim.surgery.clips.clip import Clip
from tissue_sim.surgery.clips.slip import Pull
from tissue_sim.surgery.conditions import Conditions
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.grasp import Grasp
from tissue_sim.surgery.injury import Injury, LimitReading
from tissue_sim.surgery.leak import Leak
from tissue_sim.surgery.parting import Opening
from tissue_sim.surgery.record import Record
from tissue_sim.surgery.tear import Tear

SAVED_CLASSES = {
    kind.__name__: kind
    for kind in (
        Anatomy, Artery, Clip, Conditions, Crossing, Cut, Grasp, Injury, Leak, LimitReading,
        Opening, Pull, Record, Tear,
    )
}  # fmt: skip
"""The classes that a state holds, by their names in saved states."""

REST = "rest"
BLOCK_BYTES = 32768  # the rest is padded to a multiple of this, so that states can be stacked


def state_to_tensors(state: dict[str, Any]) -> dict[str, torch.Tensor]:
    """Convert nested dicts and tuples to one flat dict, keyed by path."""
    tensors = {path: torch.from_numpy(a.copy())[None] for path, a in _arrays(state, "")}
    data = json.dumps(_coded(_without_arrays(state))).encode()
    data = data.ljust(-(-len(data) // BLOCK_BYTES) * BLOCK_BYTES)
    tensors[REST] = torch.from_numpy(np.frombuffer(data, np.uint8).copy())[None]
    return tensors


def state_from_tensors(tensors: dict[str, Any]) -> dict[str, Any]:
    """Return the state that was given to `state_to_tensors`.

    Raises:
        ValueError: a tensor is missing, unknown or not a batch of one, or the rest is not that
            of a state.
    """
    if not isinstance(tensors, dict):
        raise ValueError(f"state: it is a {type(tensors).__name__}; expected: dict")
    arrays = {path: _array(tensor, path) for path, tensor in tensors.items()}
    if REST not in arrays:
        raise ValueError(f"state: {REST!r} is missing")
    try:
        skeleton = _decoded(json.loads(arrays.pop(REST).tobytes()))
    except (
        ValueError,
        TypeError,
        LookupError,
        AttributeError,
        ImportError,
        ArithmeticError,
        RecursionError,
    ) as error:
        raise ValueError(f"state: {REST!r} is not a world's: {error!r:.80}") from error
    state = _filled(skeleton, arrays, "")
    if arrays:
        raise ValueError(f"state: unknown: {', '.join(sorted(map(str, arrays)))}")
    return state


def _coded(node: Any) -> Any:
    """Convert to JSON; a type that JSON lacks becomes an object of one entry, with its name."""
    if is_dataclass(node):
        values = {k: _coded(v) for k, v in vars(node).items()}
        return {"class": [type(node).__qualname__, values]}
    if isinstance(node, dict):
        return {"dict": {k: _coded(v) for k, v in node.items()}}
    if isinstance(node, tuple):
        return {"tuple": [_coded(v) for v in node]}
    if isinstance(node, frozenset):
        return {"frozenset": sorted(node)}
    if isinstance(node, np.ndarray):
        return {"array": [node.dtype.str, list(node.shape), node.ravel().tolist()]}
    return node.item() if isinstance(node, np.generic) else node


def _decoded(node: Any) -> Any:
    if not isinstance(node, dict):
        return node
    ((kind, parts),) = node.items()
    if kind == "class":
        name, values = parts
        return _data_class(name)(**{k: _decoded(v) for k, v in values.items()})
    if kind == "dict":
        return {k: _decoded(v) for k, v in parts.items()}
    if kind == "tuple":
        return tuple(_decoded(v) for v in parts)
    if kind == "array":
        dtype, shape, numbers = parts
        if np.dtype(dtype).kind not in "biuf":
            raise ValueError(f"no state of a world holds an array of {dtype}")
        return np.array(numbers, dtype).reshape(shape)
    return {"frozenset": frozenset}[kind](parts)


def _data_class(name: str) -> type:
    """Return one of the classes that a state holds; nothing else is ever called.

    States of earlier versions name the module too, as in "tissue_sim.record:Record".
    """
    module, _, short = name.rpartition(":")
    if short not in SAVED_CLASSES or not (not module or module.startswith("tissue_sim.")):
        raise ValueError(f"no state of a world holds {name}")
    return SAVED_CLASSES[short]


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
    """Replace each array by None."""
    if isinstance(node, np.ndarray):
        return None
    if isinstance(node, dict):
        return {k: _without_arrays(v) for k, v in node.items()}
    return tuple(_without_arrays(v) for v in node) if isinstance(node, tuple) else node


def _filled(node: Any, arrays: dict[str, NDArray[Any]], path: str) -> Any:
    """Replace each None of a skeleton by its array, and remove it from `arrays`."""
    if node is None:
        if path not in arrays:
            raise ValueError(f"state: {path!r} is missing")
        return arrays.pop(path)
    if isinstance(node, dict):
        return {k: _filled(v, arrays, f"{path}/{k}" if path else str(k)) for k, v in node.items()}
    if isinstance(node, tuple):
        return tuple(_filled(v, arrays, f"{path}/{i}") for i, v in enumerate(node))
    return node


def _array(tensor: Any, path: str) -> NDArray[Any]:
    if not isinstance(tensor, torch.Tensor | np.ndarray) or tuple(tensor.shape[:1]) != (1,):
        raise ValueError(f"state: {path!r} is no tensor with a batch of one in front")
    array = tensor.detach().cpu().numpy() if isinstance(tensor, torch.Tensor) else tensor
    return array[0].copy()
