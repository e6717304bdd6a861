"""Tests of the periods: the control period is defined in one file only."""

import ast
from pathlib import Path

import pytest

from tissue_sim.constants import CONTROL_HZ, CONTROL_PERIOD_S
from tissue_sim.world import WorldConfig

ROOT = Path(__file__).parents[2]
PACKAGES = ("tissue_sim", "planner", "controller", "scenarios")
OWNER = "tissue_sim/constants.py"
VISCOSITY = "tissue_sim/mechanics/step.py"  # a time of the material, by chance also 1/30 s


def test_the_control_period_is_one_over_its_rate():
    assert 1.0 / CONTROL_HZ == CONTROL_PERIOD_S == WorldConfig().control_step_s


@pytest.mark.parametrize("package", PACKAGES)
def test_no_other_file_spells_out_the_control_period(package):
    found = {
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / package).rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if _is_one_thirtieth(node)
    }
    assert found == ({OWNER, VISCOSITY} if package == "tissue_sim" else set())


def _is_one_thirtieth(node: ast.AST) -> bool:
    match node:
        case ast.BinOp(left=ast.Constant(value=1), op=ast.Div(), right=ast.Constant(value=30)):
            return True
        case ast.Constant(value=float(value)):
            return abs(value - CONTROL_PERIOD_S) < 1e-4
    return False
