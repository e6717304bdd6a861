"""Write files completely or not at all, and read untrusted ones without harm.

Nothing of a .npz file is unpacked before its size is known. JSON text has finite numbers only, and
no deep nesting.
"""

from __future__ import annotations

import json
import math
import os
import zlib
from collections.abc import Mapping
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from tokenize import TokenError
from typing import IO, Any, NoReturn
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

DAMAGED = (
    *(BadZipFile, zlib.error, EOFError, NotImplementedError, RecursionError),
    *(TokenError, SyntaxError),  # of NumPy, which reads an array's header as Python
)
"""Exceptions besides ValueError that reading a damaged .npz file raises."""

ENCRYPTED = 0x41  # flags of a zip's member
SUFFIX = ".npy"


def read_npz(path: Path, most_bytes: int, only: str | None = None) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file, or the named one; the arrays are read-only.

    Args:
        path: The file.
        most_bytes: Largest size of all arrays together, unpacked.
        only: Name of the one array to unpack.

    Raises:
        ValueError: The file is no .npz, too large, encrypted or damaged. The message is one line.
        OSError: The file cannot be read.
    """
    try:
        with ZipFile(path) as file:
            members = _members(file, most_bytes)
            chosen = members if only is None else {only: members[only]}
            arrays = {}
            for name, member in chosen.items():
                with file.open(member) as packed:
                    arrays[name] = _array(packed, name)
            return arrays
    except KeyError as error:
        raise ValueError(f"{error} is missing") from None
    except DAMAGED as error:
        raise ValueError(" ".join(str(error).split()) or type(error).__name__) from None


def content_hash(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return the SHA-256 of arrays with their names, types and shapes."""
    digest = sha256()
    for name in sorted(arrays):
        array = arrays[name]
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _members(file: ZipFile, most_bytes: int) -> dict[str, ZipInfo]:
    """Return the members by their arrays' names, if they are not too large."""
    members = {info.filename.removesuffix(SUFFIX): info for info in file.infolist()}
    if len(members) < len(file.infolist()):
        raise ValueError("an array is in it twice")
    for name, info in members.items():
        if info.flag_bits & ENCRYPTED or info.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
            raise ValueError(f"{name!r} is encrypted, or packed in an unusual way")
    if (size := sum(info.file_size for info in members.values())) > most_bytes:
        raise ValueError(f"it unpacks to {size / 1e9:.2f} GB; allowed: {most_bytes / 1e9:.2f} GB")
    return members


def _array(file: IO[bytes], name: str) -> NDArray[Any]:
    """Return an array; its size is the member's size, whatever the header claims."""
    if npy.read_magic(file) != (1, 0):
        raise ValueError(f"{name!r} is of another version of .npy")
    shape, by_columns, dtype = npy.read_array_header_1_0(file)
    if by_columns or dtype.hasobject or dtype.itemsize == 0:
        raise ValueError(f"{name!r} is an array of {dtype}, or by columns")
    return np.frombuffer(file.read(), dtype).reshape(shape)


# JSON text

LARGEST = 2**63  # a whole number is smaller


def from_json(text: str | bytes) -> Any:
    """Return the content of a JSON text.

    Raises:
        ValueError: The text is not JSON, or has NaN, an infinite or a huge number, or deep nesting.
    """
    try:
        return json.loads(text, parse_constant=_refuse, parse_float=_finite, parse_int=_whole)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    except TypeError:
        raise ValueError(f"it is a {type(text).__name__}, not text") from None


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number of JSON")


def _finite(text: str) -> float:
    if not math.isfinite(number := float(text)):
        raise ValueError(f"{text:.20} is infinite")
    return number


def _whole(text: str) -> int:
    if len(text) > len(str(LARGEST)) or abs(number := int(text)) >= LARGEST:
        raise ValueError(f"{text:.20}... is a huge number")
    return number


# Files that are written

MOST_MOVES = 3


def write_atomic(path: Path, content: bytes) -> None:
    """Write `content` to `path` through a temporary file beside it; create its folder.

    The function begins again if the folder is moved away meanwhile.
    """
    for _ in range(MOST_MOVES):
        with suppress(FileNotFoundError):
            return _write(path, content)
    return _write(path, content)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
