"""Check before any work that the nodes of a Ray cluster can do the work."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import NamedTemporaryFile

import ray  # pyright: ignore[reportMissingImports]
from ray.exceptions import RayError  # pyright: ignore
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy  # pyright: ignore

from scenarios.workers.ray_workers import reason
from tissue_sim.constants import WORLD_VERSION

WITHIN_S = 120.0  # a node's first task imports everything


def obstacles(folders: Sequence[Path]) -> Iterator[str]:
    """Yield why nodes cannot work: another version of Calot, none, or a folder not shared."""
    with ExitStack() as stack:
        marks = [
            stack.enter_context(NamedTemporaryFile(dir=_existing(folder))).name
            for folder in folders
        ]
        nodes = [node for node in ray.nodes() if node["Alive"] and node["Resources"].get("CPU")]
        answers = [_asked(node["NodeID"], marks) for node in nodes]
        for node, answer in zip(nodes, answers, strict=True):
            if obstacle := _received(answer):
                yield f"node {node['NodeManagerAddress']}: {obstacle}"


def _existing(folder: Path) -> Path:
    folder = folder.absolute()
    return next(path for path in (folder, *folder.parents) if path.is_dir())


def _asked(node: str, marks: Sequence[str]) -> ray.ObjectRef:
    there = NodeAffinitySchedulingStrategy(node, soft=False)
    task = ray.remote(num_cpus=0)(_obstacle).options(scheduling_strategy=there)
    return task.remote(WORLD_VERSION, marks)


def _obstacle(world_version: int, marks: Sequence[str]) -> str | None:
    """Return why this node cannot work; runs on the node itself."""
    if world_version != WORLD_VERSION:
        return f"its Calot has world version {WORLD_VERSION}, not {world_version}"
    unseen = [str(Path(mark).parent) for mark in marks if not Path(mark).exists()]
    return f"it does not see {unseen[0]}: all nodes must share this disk" if unseen else None


def _received(answer: ray.ObjectRef) -> str | None:
    try:
        return ray.get(answer, timeout=WITHIN_S)
    except RayError as error:
        return reason(error)
