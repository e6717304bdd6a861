"""Convert a whole state to tensors and back, exactly, for saved trajectories.

Arrays become tensors of the same type with a leading batch axis of one, in nested dicts. For the
mesh, this applies only to the arrays that change in each step. The other arrays are stored as
differences from the patient's mesh as built. Nearly all differences are zero and compress to
nothing. These differences and all values that are no arrays (clips, cuts, injuries, the anatomy)
become the bytes of one tensor.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator
from dataclasses import is_dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import Anatomy, Artery
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.tubes import Crossing, Tubes
from tissue_sim.state_check import require_names, require_type
from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.clip_slip import Pull
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.grasp import Grasp
from tissue_sim.surgery.injury import Injury, LimitReading
from tissue_sim.surgery.leak import Leak, Spill
from tissue_sim.surgery.parting import Opening
from tissue_sim.surgery.record import Conditions, Record
from tissue_sim.surgery.tear import Tear
from tissue_sim.tools.clips import ClipKind

SAVED_CLASSES = {
    kind.__name__: kind
    for kind in (
        Anatomy, Artery, Clip, ClipKind, Conditions, Crossing, Cut, Grasp, Injury, Leak,
        LimitReading, Opening, Pull, Record, Spill, Tear,
    )
}  # fmt: skip
"""The classes that a state holds, by their names in saved states."""

REST = "rest"
BLOCK_BYTES = 32768  # the rest is padded to a multiple of this size, so that states can be stacked
MOST_BYTES = 1 << 24  # largest unpacked rest; a rest has half a megabyte
MOVING = ("position", "velocity", "stiffness_at")  # tissue arrays; others seldom change

Tensors = dict[str, Any]


def state_to_tensors(state: dict[str, Any]) -> Tensors:
    """Convert a state, `{"anatomy": Anatomy, "world": World.state()}`, to nested dicts of tensors.

    The dicts and the shapes of the tensors are the same for all states of a patient.
    """
    arrays, built = dict(_arrays(state, "")), mesh_as_built(state["anatomy"])
    differences = b"".join(_xor(arrays.pop(path), own).tobytes() for path, own in built.items())
    text = json.dumps({"mesh": _digest(built), "state": _coded(_without_arrays(state))})
    data = zlib.compress(text.encode() + b"\0" + differences)
    data = data.ljust(-(-len(data) // BLOCK_BYTES) * BLOCK_BYTES, b"\0")
    arrays[REST] = np.frombuffer(data, np.uint8)
    return nested({path: torch.from_numpy(a.copy())[None] for path, a in arrays.items()})


def state_from_tensors(tensors: Tensors) -> dict[str, Any]:
    """Return the state that was given to `state_to_tensors`.

    Args:
        tensors: The returned value: torch or NumPy, nested or by path, with or without batch axis.

    Raises:
        ValueError: A tensor is missing, unknown or not a batch of one. Or the remaining values do
            not form a state. Or the patient's mesh differs from the mesh here.
    """
    if not isinstance(tensors, dict):
        raise ValueError(f"state: it is a {type(tensors).__name__}; expected: dict")
    arrays = _plain_arrays(flat(tensors))
    mesh, skeleton, differences = _unpacked(arrays.pop(REST))
    require_type(skeleton, dict, "state")
    require_names(set(skeleton), {"anatomy", "world"}, "state")
    require_type(skeleton["anatomy"], Anatomy, "state/anatomy")
    built = mesh_as_built(skeleton["anatomy"])
    if mesh != _digest(built):
        raise ValueError("state: other versions of the libraries built another mesh there")
    left = arrays | _applied(differences, built)
    state = _filled(skeleton, left, "")
    unknown = left.keys() | arrays.keys() & built.keys()
    if unknown:
        raise ValueError(f"state: unknown: {', '.join(sorted(map(str, unknown)))}")
    return state


@lru_cache(maxsize=64)
def mesh_as_built(anatomy: Anatomy) -> dict[str, NDArray[Any]]:
    """Return the seldom changing arrays of a patient's mesh before the first step, by path.

    Raises:
        ValueError: the patient cannot be meshed.
    """
    organ = build_organ(anatomy)
    tissue = Tissue([organ], stiffness_scale=[anatomy.stiffness_scale])
    tubes = Tubes(tissue, organ)
    still = {name: part for name, part in tissue.parts().items() if name not in MOVING}
    parts = {"tissue": still, "above": tubes.above, "stations": tubes.stations_m}
    return {path: a.copy() for path, a in _arrays({"world": parts}, "")}


def flat(tensors: Tensors, path: str = "") -> Tensors:
    """Return nested dicts as one dict by path, such as "world/tissue/position"."""
    if not isinstance(tensors, dict):
        return {path: tensors}
    parts = (flat(v, f"{path}/{k}" if path else str(k)) for k, v in tensors.items())
    return {k: v for part in parts for k, v in part.items()}


def nested(by_path: Tensors) -> Tensors:
    """Return the nested dicts that `flat` flattened."""
    tree: Tensors = {}
    for path, tensor in by_path.items():
        *above, name = path.split("/")
        node = tree
        for part in above:
            node = node.setdefault(part, {})
        node[name] = tensor
    return tree


def _xor(array: NDArray[Any], own: NDArray[Any]) -> NDArray[np.uint8]:
    return np.bitwise_xor(_bytes_of(array), _bytes_of(own))


def _bytes_of(array: NDArray[Any]) -> NDArray[np.uint8]:
    return np.frombuffer(array.tobytes(), np.uint8)


def _digest(mesh: dict[str, NDArray[Any]]) -> str:
    return hashlib.sha256(b"".join(a.tobytes() for a in mesh.values())).hexdigest()[:12]


def _applied(differences: bytes, built: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return the mesh's arrays: the arrays as built, with the differences applied."""
    ends = np.cumsum([own.nbytes for own in built.values()])
    if len(differences) != ends[-1]:
        raise ValueError(f"state: {REST!r} holds {len(differences)} bytes of {ends[-1]}")
    pieces = np.split(np.frombuffer(differences, np.uint8), ends[:-1])
    return {
        path: np.bitwise_xor(piece, _bytes_of(own)).view(own.dtype).reshape(own.shape)
        for (path, own), piece in zip(built.items(), pieces, strict=True)
    }


def _unpacked(rest: NDArray[Any]) -> tuple[str, Any, bytes]:
    """Return a rest's mesh digest, its state with None for arrays, and the mesh's differences."""
    try:
        inflate = zlib.decompressobj()
        data = inflate.decompress(rest.tobytes(), MOST_BYTES)
        if not inflate.eof:
            raise ValueError("it is cut short")
        text, _, differences = data.partition(b"\0")
        packed = json.loads(text)
        return packed["mesh"], _decoded(packed["state"]), differences
    except (
        zlib.error,
        ValueError,
        TypeError,
        LookupError,
        AttributeError,
        ImportError,
        ArithmeticError,
        RecursionError,
    ) as error:
        raise ValueError(f"state: {REST!r} is not a world's: {error!r:.80}") from error


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
    """Return one of the classes that a state contains; nothing else is ever called.

    States of earlier versions also name the module, as in "tissue_sim.record:Record".
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
    """Replace each None of a skeleton by its array, and remove the array from `arrays`."""
    if node is None:
        if path not in arrays:
            raise ValueError(f"state: {path!r} is missing")
        return arrays.pop(path)
    if isinstance(node, dict):
        return {k: _filled(v, arrays, f"{path}/{k}" if path else str(k)) for k, v in node.items()}
    if isinstance(node, tuple):
        return tuple(_filled(v, arrays, f"{path}/{i}") for i, v in enumerate(node))
    return node


def _plain_arrays(tensors: Tensors) -> dict[str, NDArray[Any]]:
    """Return the tensors as arrays without the batch axis, which all tensors or none have."""
    if REST not in tensors:
        raise ValueError(f"state: {REST!r} is missing")
    batched = np.ndim(tensors[REST]) > 1
    return {path: _array(tensor, path, batched) for path, tensor in tensors.items()}


def _array(tensor: Any, path: str, batched: bool) -> NDArray[Any]:
    if not isinstance(tensor, torch.Tensor | np.ndarray):
        raise ValueError(f"state: {path!r} is no tensor but a {type(tensor).__name__}")
    array = tensor.detach().cpu().numpy() if isinstance(tensor, torch.Tensor) else tensor
    if batched and array.shape[:1] != (1,):
        raise ValueError(f"state: {path!r} has no batch of one in front")
    return (array[0] if batched else array).copy()
