"""Define the files of a dataset: LeRobot's dataset v3, written from its public description."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from controller.dataset.schema import (
    FPS,
    PICTURE_SHAPE,
    PICTURES,
    SCHEMA_VERSION,
    TEXTS,
    Feature,
    features,
)
from tissue_sim.constants import WORLD_VERSION

CODEBASE_VERSION = "v3.0"
FILES_A_CHUNK = 1000
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
EPISODES_PATH = "meta/episodes/chunk-000/file-000.parquet"
TASKS_PATH = "meta/tasks.parquet"
STATS_PATH = "meta/stats.json"
INFO_PATH = "meta/info.json"
DATA_FILE_MAX_MB = 100


def data_path(file: int) -> str:
    """Return the path of the n-th file of frames."""
    chunk, within = divmod(file, FILES_A_CHUNK)
    return DATA_PATH.format(chunk_index=chunk, file_index=within)


def video_path(camera: str, file: int) -> str:
    """Return the path of a camera's n-th file of pictures."""
    chunk, within = divmod(file, FILES_A_CHUNK)
    return VIDEO_PATH.format(video_key=PICTURES + camera, chunk_index=chunk, file_index=within)


def info(episodes: int, frames: int, cameras: Sequence[str] = ()) -> dict[str, Any]:
    """Return the content of meta/info.json; the key `calot` is our own."""
    columns = {name: _described(feature) for name, feature in features(cameras).items()}
    return {
        "codebase_version": CODEBASE_VERSION,
        "robot_type": "two simulated da Vinci PSMs",
        "total_episodes": episodes,
        "total_frames": frames,
        "total_tasks": len(TEXTS),
        "chunks_size": FILES_A_CHUNK,
        "data_files_size_in_mb": DATA_FILE_MAX_MB,
        "video_files_size_in_mb": 200,
        "fps": FPS,
        "splits": {"train": f"0:{episodes}"},
        "data_path": DATA_PATH,
        "video_path": VIDEO_PATH if cameras else None,
        "features": columns | {PICTURES + camera: _VIDEO for camera in cameras},
        "calot": {
            "schema_version": SCHEMA_VERSION,
            "world_version": WORLD_VERSION,
            "cameras": list(cameras),
        },
    }


def _described(feature: Feature) -> Mapping[str, Any]:
    return {"dtype": feature.dtype, "shape": [feature.size], "names": None, "fps": FPS}


_VIDEO = {
    "dtype": "video",
    "shape": list(PICTURE_SHAPE),
    "names": ["height", "width", "channels"],
    "info": {
        "video.height": PICTURE_SHAPE[0],
        "video.width": PICTURE_SHAPE[1],
        "video.channels": PICTURE_SHAPE[2],
        "video.codec": "h264",
        "video.pix_fmt": "yuv420p",
        "video.is_depth_map": False,
        "video.fps": FPS,
        "has_audio": False,
    },
}
