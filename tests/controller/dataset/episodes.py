"""Made-up episodes for tests: random numbers in the columns of the schema."""

import numpy as np

from controller.dataset.dataset_episode import DatasetEpisode, Header
from controller.dataset.part import part_bytes
from controller.dataset.schema import DEMONSTRATED, TEXTS
from controller.dataset.tables import strings


def random_episode(seed, frames=50, **changes):
    rng = np.random.default_rng(seed)
    columns = {name: _random(feature, frames, rng) for name, feature in DEMONSTRATED.items()}
    columns["instruction"] = strings([TEXTS[k] for k in columns["task_index"]])
    columns["segment"] = np.sort(columns["segment"])
    header = Header(
        seed=seed,
        kind="nominal",
        scenario="nominal",
        success=True,
        failures=(),
        anatomy={"hash": f"{seed}"},
        versions={"calot": "0"},
    )
    return DatasetEpisode(header=header, columns=columns | changes)


def _random(feature, frames, rng):
    if feature.dtype == "string":
        return strings(rng.choice(["", "move left arm higher"], frames).tolist())
    if feature.dtype == "bool":
        return rng.uniform(size=frames) < 0.7
    if feature.dtype == "int64":
        return rng.integers(0, 3, frames)
    return rng.normal(size=feature.shape(frames)).astype(feature.dtype)


def write_parts(folder, seeds, **options):
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{seed:05d}-nominal.parquet" for seed in seeds]
    for seed, path in zip(seeds, paths, strict=True):
        path.write_bytes(part_bytes(random_episode(seed, **options)))
    return paths
