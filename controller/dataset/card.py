"""Write the card of a dataset, which describes its contents to readers elsewhere."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from math import prod
from pathlib import Path
from typing import Any

from controller.dataset.schema import FPS
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.sensing.observation import ENCODED, VECTOR_LAYOUT

CARD_PATH = "README.md"
_HEAD = """---
license: apache-2.0
task_categories: [robotics]
tags: [LeRobot, calot, surgery]
configs:
- config_name: default
  data_files: data/*/*.parquet
---
"""


def is_foreign(path: Path) -> bool:
    """Return whether a file exists that Calot did not write as a card, and that must stay."""
    return path.exists() and not path.read_text(errors="replace").startswith(_HEAD)


def card(rows: Sequence[Mapping[str, Any]], cameras: Sequence[str]) -> str:
    """Return the card in Markdown, from the rows of `meta/episodes`."""
    kinds = Counter(row["kind"] for row in rows)
    frames = sum(row["length"] for row in rows)
    seeds = sorted({row["seed"] for row in rows})
    passed = len({row["seed"] for row in rows if row["success"]})
    told = (
        f"pictures of {', '.join(cameras)} (`observation.images.*`) and what encoders and motor"
        " currents tell (`observation.state`)"
        if cameras
        else "what encoders and motor currents tell (`observation.state`) and the tissue as a model"
        " of the senses sees it (`observation.environment_state`)"
    )
    split = " Each is a stretch that the expert led without a break." if cameras else ""
    lines = [
        _HEAD,
        "# Clipping and cutting in gallbladder removal, simulated by Calot",
        "",
        f"{len(rows)} episodes with {frames} frames, {FPS} a second.{split} {len(seeds)} patients"
        f" (seeds {seeds[0]} to {seeds[-1]}), {passed} with a procedure that passed; world version"
        f" {WORLD_VERSION}.",
        "",
        f"The robot is told {told}. `privileged.state` is the simulator's state, which no robot"
        " has: it is no input of a policy. `action` moves both arms in the endoscope's frame."
        " `instruction` is what the planner or a person said.",
        "",
        "| kind | episodes |",
        "|---|---|",
        *(f"| {kind} | {n} |" for kind, n in sorted(kinds.items())),
        "",
        "| numbers of `observation.state` | what, by its name in `Observation` |",
        "|---|---|",
        *_numbers(),
        "",
        "`action` has ten numbers for the left arm, then ten for the right: the way of its tip"
        " (3, m), the first two columns of its turn (6), and the angle of its jaws (1, rad).",
        "",
        "Patients and tissue are simulated: no person's data are in it, and nothing here is fit for"
        " use on people.",
    ]
    return "\n".join(lines) + "\n"


def _numbers() -> Iterator[str]:
    """Yield a row for each part of `observation.state`: its range of numbers and its meaning."""
    first = 0
    for name in ENCODED:
        shape = VECTOR_LAYOUT[name]
        end = first + prod(shape)
        numbers = f"{first} to {end - 1}" if end > first + 1 else f"{first}"
        yield f"| {numbers} | `{name}`, {' x '.join(map(str, shape))} |"
        first = end
