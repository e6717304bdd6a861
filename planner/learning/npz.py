"""Read a .npz file from an untrusted source: nothing is unpacked before its size is known."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import IO, Any
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

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
    except (BadZipFile, zlib.error, EOFError, NotImplementedError, RecursionError) as error:
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
