"""Made-up episodes for tests: random numbers in the columns of the schema."""

import numpy as np

from controller.dataset.dataset_episode import DatasetEpisode, Header
from controller.dataset.part import part_bytes, video_path
from controller.dataset.schema import NOT_FORKED, PICTURE_SHAPE, TEXTS, demonstrated
from controller.dataset.tables import strings
from tissue_sim.rendering.video import Video


def random_episode(seed, frames=50, cameras=(), **changes):
    rng = np.random.default_rng(seed)
    columns = {
        name: _random(feature, frames, rng) for name, feature in demonstrated(cameras).items()
    }
    columns["instruction"] = strings([TEXTS[k] for k in columns["task_index"]])
    columns["segment"] = np.sort(columns["segment"])
    columns["forked_from"] = np.full(frames, NOT_FORKED)
    columns["task"] += 1  # they count from 1
    header = Header(
        seed=seed,
        kind="nominal",
        scenario="nominal",
        success=True,
        failures=(),
        anatomy={"hash": f"{seed}"},
        versions={"calot": "0"},
        cameras=cameras,
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


def grey(frame):
    """Return a picture whose grey tells the frame's number, below 60."""
    return np.full(PICTURE_SHAPE, 4 * frame, np.uint8)


def frame_of(picture):
    """Return the number of the frame that a picture of `grey` was taken before."""
    return round(float(picture.mean()) / 4)


def write_parts(folder, seeds, **options):
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{seed:05d}-nominal.parquet" for seed in seeds]
    for seed, path in zip(seeds, paths, strict=True):
        episode = random_episode(seed, **options)
        path.write_bytes(part_bytes(episode))
        for camera in episode.header.cameras:
            with Video(video_path(path, camera), keyframes=2) as video:
                for frame in range(len(episode)):
                    video.add(grey(frame))
    return paths
