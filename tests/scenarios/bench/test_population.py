"""Tests of the population bench: its table shows the patients, and shares are published."""

import math
from pathlib import Path

import pytest

from scenarios.bench.population import SHARES, drawn, population_table
from scenarios.cli import main
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.population import PUBLISHED

PLOT = Path(__file__).parents[3] / "docs/anatomy.png"
BESIDE = 0.02  # a fitted law need not meet a share that it was not fitted to exactly


@pytest.fixture(scope="module")
def patients():
    return drawn(40_000, 3000)


@pytest.mark.parametrize("title", SHARES)
def test_drawn_shares_are_the_published_ones(patients, title):
    low, high, has = SHARES[title]
    found = sum(map(has, patients)) / len(patients)
    sampling = 4.5 * math.sqrt(found * (1 - found) / len(patients))
    assert low - BESIDE - sampling < found < high + BESIDE + sampling


def test_the_table_tells_each_mean_as_published_and_as_drawn(patients):
    parameter, published, found = (list(c.cells) for c in population_table(patients).columns)
    assert len(parameter) == len(PUBLISHED) + len(SHARES)
    row = parameter.index("duct length (mm)")
    mean_mm = 1e3 * sum(p.duct_length_m for p in patients) / len(patients)
    assert published[row] == "20.6 ± 11.4 (6 to 55)"
    assert found[row].startswith(f"{mean_mm:.3g} ± ")
    doubles = sum(p.second_artery is not None for p in patients)
    assert found[parameter.index("two arteries")] == f"{100 * doubles / len(patients):.1f} %"


def test_patients_are_those_of_the_seeds(patients):
    assert patients[:3] == tuple(anatomy_from_seed(seed) for seed in (40_000, 40_001, 40_002))


def test_the_command_prints_the_table_and_the_committed_plot_is_small(capsys):
    assert main(["bench", "population", "--patients", "200"]) == 0
    assert "duct length (mm)" in capsys.readouterr().out
    assert PLOT.stat().st_size < 150_000
