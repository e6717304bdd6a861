"""Define classes for segmentation pictures, by the names of the drawn entities."""

from __future__ import annotations

import numpy as np
import sapien
from numpy.typing import NDArray

CLASSES = (
    "nothing",
    "cavity",
    "liver",
    "fat",
    "common bile duct",
    "hepatic artery",
    "gallbladder",
    "duct",
    "artery",
    "cut wall",
    "cut lumen",
    "clip",
    "duct leak",
    "artery leak",
    "psm1",
    "psm2",
    "gallbladder leak",
    "second artery",
    "second artery leak",
    "peritoneum",
    "duodenum",
    "common bile duct leak",
    "hepatic artery leak",
    "assistant",
    "lymph node",
)


def classes_of_entities(scene: sapien.Scene) -> NDArray[np.int16]:
    """Return each entity's place in `CLASSES`, indexed by its number in the scene."""
    numbers = {e.per_scene_id: e.name.split(":")[0] for e in scene.entities}
    classes = np.zeros(max(numbers) + 1, np.int16)
    for number, name in numbers.items():
        if name in CLASSES:
            classes[number] = CLASSES.index(name)
    return classes
