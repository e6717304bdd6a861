"""What kind of thing does a sentence say? Fine-tuned layers of the sentence encoder tell.

Lists of words and patterns read about 84 % of the sentences of writers who have not seen them.
Further lists did not help. So the last layers of the encoder and a linear head were trained on
outsiders' sentences (`train_kinds.py`). They tell apart questions, warnings, bans, permissions,
words to go on, dangerous requests, orders and other talk.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Literal, cast, get_args

import torch
from safetensors.torch import load_file, save
from torch import Tensor
from torch.nn import functional as F

from planner.language.rules.foreign import in_english
from planner.language.rules.questions import QUESTIONS, Question
from planner.language.rules.spelling import as_meant, in_latin
from planner.language.sentence_encoder import LAYERS, hidden_states, layer
from planner.language.sentence_sets import holds
from planner.learning.files import write_atomic
from planner.learning.networks import one_thread

Other = Literal["hold", "forbid", "allow", "resume", "refuse", "order", "none"]
Kind = Question | Other
KINDS: tuple[Kind, ...] = (*QUESTIONS, *get_args(Other))
FROZEN = 3  # first layers of the encoder, which are not trained
SHIPPED = Path(__file__).with_name("kind_head.safetensors")

# Probability from which the arms hold, and that where something else is guessed; that from which
# another kind is taken for sure. Chosen on sets that the head was not trained on: a warning that is
# missed may injure, one that is heard in vain costs a second.
ALARMED, GUESSED, SURE = 0.25, 0.5, 0.5
OVERRULES = 0.98  # that from which the head overrules rules that read something else,
LETS_ACT = 0.995  # and that from which words to go on and permissions need no confirmation


def kind_of(expected: str) -> Kind:
    """Return the kind of a meaning that a sentence set writes: "hold: no cut duct" is "forbid"."""
    if holds(expected):
        return "forbid" if ": no " in expected else "hold"
    kind = expected.split(": ")[-1 if expected.startswith("question: ") else 0]
    return cast("Kind", kind) if kind in KINDS else "order"


def kind_in(found: Mapping[Kind, float], *, guessed: bool = False) -> Kind | None:
    """Return the kind of a text that no rule reads, by its `chances`; None where it is not sure.

    Args:
        guessed: it may mean a command, "cut that one", or tells how things are; it is asked back
            otherwise, or compared with what is seen.
    """
    likeliest = _likeliest(found)
    if found["hold"] + found["forbid"] > (GUESSED if guessed else ALARMED):
        return "forbid" if likeliest == "forbid" else "hold"
    return likeliest if found[likeliest] >= SURE else None


def kind_instead(found: Mapping[Kind, float], from_chance: float = OVERRULES) -> Kind | None:
    """Return the kind that a text surely has, whatever rules read in it; None if none is sure."""
    likeliest = _likeliest(found)
    return likeliest if found[likeliest] >= from_chance else None


def _likeliest(found: Mapping[Kind, float]) -> Kind:
    return max(found, key=found.__getitem__)


def chances(text: str) -> dict[Kind, float]:
    """Return the probability of each kind for a text."""
    w = _weights()
    with torch.inference_mode(), one_thread():
        hidden = hidden_states(in_words(text), FROZEN)
        p = F.softmax(logits(hidden[None], torch.ones(1, len(hidden), dtype=torch.bool), w)[0], -1)
    return dict(zip(KINDS, p.tolist(), strict=True))


def in_words(text: str) -> str:
    """Return a text as the head takes it: in English, with its stock mishearings mended."""
    return in_english(as_meant(in_latin(text))).lower()


def logits(hidden: Tensor, mask: Tensor, w: Mapping[str, Tensor]) -> Tensor:
    """Return the logits (n, kinds) of texts.

    Args:
        hidden: (n, tokens, 384), after the frozen layers.
        mask: (n, tokens), false for padding.
        w: weights of the other layers and of the head.
    """
    for k in range(FROZEN, LAYERS):
        hidden = layer(hidden, w, k, mask)
    states = hidden * mask[..., None]
    mean = states.sum(dim=1) / mask.sum(dim=1, keepdim=True)
    return F.linear(mean, w["head.weight"], w["head.bias"])


def save_weights(w: Mapping[str, Tensor], path: Path = SHIPPED) -> None:
    """Write weights, rounded to 16 bits."""
    write_atomic(path, save({name: one.detach().half().contiguous() for name, one in w.items()}))


@cache
def _weights() -> dict[str, Tensor]:
    return {name: one.float() for name, one in load_file(SHIPPED).items()}
