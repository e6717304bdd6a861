"""Compute statistics of columns, of one episode and pooled over many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from controller.dataset.schema import Feature

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
Statistics = dict[str, np.ndarray]  # min, max, mean, std, quantiles: (size,) each; count: (1,)


def statistics_of(
    columns: Mapping[str, np.ndarray], features: Mapping[str, Feature]
) -> dict[str, Statistics]:
    """Return statistics of each column of numbers, over its frames."""
    return {
        n: statistics_of_rows(columns[n].reshape(-1, f.size))
        for n, f in features.items()
        if f.is_number
    }


def pooled(parts: Sequence[Statistics]) -> Statistics:
    """Pool the statistics of parts into those of their union (law of total variance).

    Pooled quantiles are the means of the parts' quantiles, weighted by counts, as in LeRobot.
    """
    count, mean, std = (np.stack([p[key] for p in parts]) for key in ("count", "mean", "std"))
    weight = count / count.sum()
    middle = (weight * mean).sum(axis=0)
    variance = (weight * (std**2 + (mean - middle) ** 2)).sum(axis=0)
    return {
        "min": np.min([p["min"] for p in parts], axis=0),
        "max": np.max([p["max"] for p in parts], axis=0),
        "mean": middle,
        "std": np.sqrt(variance),
        "count": count.sum(axis=0),
        **{q: (weight * np.stack([p[q] for p in parts])).sum(axis=0) for q in QUANTILES},
    }


def statistics_of_rows(rows: np.ndarray) -> Statistics:
    """Return the statistics of rows (n, size)."""
    values = rows.astype(float)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([len(values)]),
        **dict(zip(QUANTILES, np.quantile(values, [*QUANTILES.values()], axis=0), strict=True)),
    }
