"""Convert columns of numpy to an Arrow table and back, bit for bit; errors are one line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa

from controller.dataset.schema import Feature


def table_of(columns: Mapping[str, np.ndarray], features: Mapping[str, Feature]) -> pa.Table:
    """Return a table of the columns that `features` names.

    Raises:
        ValueError: A column is missing, of another shape or type, or has numbers that are not
            finite.
    """
    _require(columns, features)
    arrays = [_arrow(columns[name], feature) for name, feature in features.items()]
    return pa.table(arrays, schema=arrow_schema(features))


def columns_of(table: pa.Table, features: Mapping[str, Feature]) -> dict[str, np.ndarray]:
    """Return the columns of a table; inverts `table_of`, with the same errors."""
    require_features(table.schema, features)
    columns = {
        name: _numpy(table[name].combine_chunks(), feature) for name, feature in features.items()
    }
    _require(columns, features)
    return columns


def arrow_schema(features: Mapping[str, Feature]) -> pa.Schema:
    """Return the schema with names and types; no value may be null."""
    return pa.schema([pa.field(n, f.arrow, nullable=False) for n, f in features.items()])


def require_features(schema: pa.Schema, features: Mapping[str, Feature]) -> None:
    """Raise ValueError unless all columns exist, each with its type."""
    if missing := [name for name in features if name not in schema.names]:
        raise ValueError(f"columns are missing: {', '.join(missing)}")
    for name, feature in features.items():
        if (found := schema.field(name).type) != feature.arrow:
            raise ValueError(f"column {name} is {found}, not {feature.arrow}")


def _require(columns: Mapping[str, np.ndarray], features: Mapping[str, Feature]) -> None:
    if missing := [name for name in features if name not in columns]:
        raise ValueError(f"columns are missing: {', '.join(missing)}")
    frames = len(columns[next(iter(features))])
    for name, feature in features.items():
        column, shape = columns[name], feature.shape(frames)
        dtype = "object" if feature.dtype == "string" else feature.dtype
        if column.shape != shape or column.dtype != dtype:
            found = f"{column.dtype} {column.shape}"
            raise ValueError(f"column {name} is {found}, not {dtype} {shape}")
        if column.dtype.kind == "f" and not np.isfinite(column).all():
            frame = int(np.argwhere(~np.isfinite(column))[0][0])
            raise ValueError(f"column {name} has a number that is not finite, in frame {frame}")


def _arrow(column: np.ndarray, feature: Feature) -> pa.Array:
    if feature.size == 1:
        return pa.array(column, feature.arrow)
    return pa.FixedSizeListArray.from_arrays(pa.array(column.ravel()), feature.size)


def _numpy(array: pa.Array | pa.ChunkedArray, feature: Feature) -> np.ndarray:
    if feature.size == 1:
        return array.to_numpy(zero_copy_only=False)
    return array.flatten().to_numpy(zero_copy_only=False).reshape(-1, feature.size)


def strings(values: Sequence[str]) -> np.ndarray:
    """Return a string column: objects (n,)."""
    out = np.empty(len(values), object)
    out[:] = values
    return out
