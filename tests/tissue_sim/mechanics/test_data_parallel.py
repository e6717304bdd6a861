"""Tests of the data-parallel step: one thread per element equals one per environment."""

import numpy as np
import pytest
import warp as wp

from tissue_sim.mechanics import data_parallel
from tissue_sim.mechanics.data_parallel import DataParallelTissue
from tissue_sim.mechanics.tissue import Tissue, TissueConfig
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.tubes import Tubes
from tissue_sim.patient.variants import variant
from tissue_sim.surgery.clip import CLIP_LENGTH_M, latch
from tissue_sim.surgery.clip_bar import place_bars
from tissue_sim.verification.bodies import astride

SEEDS = (10_000, 10_001)
AGREEMENT_M = 3.0e-6  # for motions of some millimetres: rounding, after both converged


def batch() -> Tissue:
    """Return two patients: one with a pushed clip, one with two arteries and a pressed sac."""
    first, second = (textbook_from_seed(seed) for seed in SEEDS)
    organs = [build_organ(first), build_organ(variant("two-arteries", second))]
    config = TissueConfig(tolerance=1e-5, settled_j=0.0, iterations=2000)
    tissue = Tissue(organs, config=config)
    tubes = Tubes(tissue, organs[0])
    T = astride(tubes, "duct", 0.5 * tubes.length_m["duct"], beyond_m=0.5 * CLIP_LENGTH_M)
    clip = latch(tubes, T, number=1, time_s=0.0)
    place_bars(tubes, [clip])
    push(tissue, 0, T[:3, 3] - CLIP_LENGTH_M * T[:3, 2])
    press(tissue, 1)
    return tissue


def push(tissue: Tissue, b: int, end_m: np.ndarray) -> None:
    """Push a ball against the end of a clip, from the side."""
    tissue.shapes.a.numpy()[b, 1] = tissue.shapes.b.numpy()[b, 1] = np.add(
        end_m, [0.002, 0.001, 0.0]
    )
    tissue.shapes.radius.numpy()[b, 1] = 0.004


def press(tissue: Tissue, b: int) -> None:
    """Press a rounded rod three millimetres into the infundibulum."""
    ring = tissue.positions(b)[tissue.organs[b].sac_rings[4]].astype(float)
    top = ring[np.argmax(ring[:, 2])]
    radius_m, reach = 0.002, np.array([0.02, 0.0, 0.0])
    middle = top + np.array([0.0, 0.0, radius_m - 0.003])
    tissue.shapes.a.numpy()[b, 4], tissue.shapes.b.numpy()[b, 4] = middle - reach, middle + reach
    tissue.shapes.radius.numpy()[b, 4] = radius_m
    tissue.shapes.friction.numpy()[b, 4] = 0.5


def test_both_paths_take_the_same_steps() -> None:
    tissue = batch()
    parallel = DataParallelTissue(tissue, device="cpu", iterations=1600)
    start = tissue.host("position").copy()
    peak = np.zeros(tissue.shapes.force.shape)
    for _ in range(5):
        tissue.step()
        parallel.step()
        peak = np.maximum(peak, np.linalg.norm(tissue.shapes.force.numpy(), axis=-1))
    moved = np.linalg.norm(tissue.host("position") - start, axis=-1).max(axis=1)
    assert (moved > 20 * AGREEMENT_M).all()
    serial = {name: tissue.host(name).copy() for name in ("position", "contact_shape")}
    force = tissue.shapes.force.numpy().copy()
    parallel.pull()
    assert np.abs(tissue.host("position") - serial["position"]).max() < AGREEMENT_M
    assert (tissue.host("contact_shape") == serial["contact_shape"]).all()
    assert (peak[[0, 1], [1, 4]] > 0.03).all()
    assert np.abs(tissue.shapes.force.numpy() - force).max() < 0.01 * np.abs(force).max()


def test_push_copies_changes_from_the_host() -> None:
    tissue = batch()
    parallel = DataParallelTissue(tissue, device="cpu", iterations=10)
    tissue.host("link_stiffness")[0] = 0.0
    parallel.push()
    assert (parallel.arrays.link_stiffness.numpy()[0] == 0.0).all()


@pytest.mark.slow
def test_the_kernels_compile_for_a_gpu(tmp_path) -> None:
    """Compile without a GPU: Warp includes its compiler."""
    made = wp.compile_aot_module(data_parallel, arch=80, use_ptx=True, module_dir=tmp_path)
    assert made
    assert all(path.stat().st_size > 0 for path in made)


@pytest.mark.gpu
@pytest.mark.skipif(wp.get_cuda_device_count() == 0, reason="no GPU")
def test_a_gpu_takes_the_same_steps_as_the_cpu() -> None:
    tissue = batch()
    on_cpu = DataParallelTissue(tissue, device="cpu", iterations=1600)
    on_gpu = DataParallelTissue(tissue, device="cuda:0", iterations=1600)
    for _ in range(5):
        on_cpu.step()
        on_gpu.step()
    difference = on_gpu.arrays.position.numpy() - on_cpu.arrays.position.numpy()
    assert np.abs(difference).max() < AGREEMENT_M
