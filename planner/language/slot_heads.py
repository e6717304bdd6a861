"""Linear heads that predict, from a sentence's embedding, the slots that its words leave open.

Softmax regression on all-MiniLM-L6-v2 embeddings. Slots filled by words are certain; the heads
predict what is done, how, and whether the robot is meant at all. They never predict sides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors import safe_open
from safetensors.numpy import save as to_bytes

from planner.command import COMMANDS, Command
from planner.language.phrases import normalised
from planner.language.rules.spelling import with_artery
from planner.language.slots import SLOTS, Filled, candidates
from planner.learning.files import write_atomic

SHIPPED = Path(__file__).with_name("slot_heads.safetensors")
NOTHING = "nothing"
IN_SCOPE = ("no", "yes")


def in_words(text: str) -> str:
    """Return a text as the heads take it: normalised, and on no other tube than they know."""
    return with_artery(normalised(text))


def labels(command: Command) -> dict[str, str]:
    """Return each head's label for a sentence that means the command."""
    said = SLOTS[command.text]
    return {"in scope": "yes", "kind": said["kind"], "what": said.get("what", NOTHING)}


def _classes() -> dict[str, tuple[str, ...]]:
    """Return the classes of each head."""
    said = [labels(command) for command in COMMANDS.values()]
    slots = {head: tuple(sorted({one[head] for one in said})) for head in ("kind", "what")}
    return {"in scope": IN_SCOPE} | slots


CLASSES = _classes()


@dataclass(frozen=True, kw_only=True)
class SlotHeads:
    """The heads and their confidence thresholds.

    Attributes:
        weights: Of each head, (385, classes); the last row is the bias.
        thresholds: Confidence below which a reading is only a guess, by openness.
    """

    weights: Mapping[str, np.ndarray]
    thresholds: Mapping[str, float]

    def ranked(self, embedding: np.ndarray, filled: Filled) -> list[tuple[float, Command]]:
        """Return every command that agrees with the words, with its confidence, highest first.

        Args:
            embedding: (384,) of the sentence.
            filled: The slots that the words fill.
        """
        chances = {
            head: _softmax(np.append(embedding, 1.0) @ w) for head, w in self.weights.items()
        }
        # predict the kind even if a word names it: an unknown word may change it, as in "clip art"
        heads = {"in scope", "kind"} | ({"what"} - filled.keys())
        rated = [(_confidence(chances, labels(c), heads), c) for c in candidates(filled)]
        return sorted(rated, key=lambda one: -one[0])


def _confidence(chances: dict[str, np.ndarray], meant: dict[str, str], heads: set[str]) -> float:
    """Return the product of the heads' probabilities, as if their errors were independent."""
    return float(np.prod([chances[h][CLASSES[h].index(meant[h])] for h in heads]))


def _softmax(logits: np.ndarray) -> np.ndarray:
    powers = np.exp(logits - logits.max())
    return powers / powers.sum()


def save(path: Path, heads: SlotHeads) -> None:
    """Write the heads."""
    thresholds = {k: f"{least:.3f}" for k, least in heads.thresholds.items()}
    write_atomic(path, to_bytes(dict(heads.weights), thresholds))


def load(path: Path = SHIPPED) -> SlotHeads:
    """Return the heads of a file."""
    with safe_open(path, "numpy") as file:
        weights = {head: file.get_tensor(head) for head in CLASSES}
        thresholds = {k: float(least) for k, least in file.metadata().items()}
        return SlotHeads(weights=weights, thresholds=thresholds)
