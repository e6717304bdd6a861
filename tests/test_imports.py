"""Tests of the layout.

Imports go one way and never in a circle. No two public classes share a name. What a policy may
import tells it nothing about the world except observations.
"""

import ast
import subprocess
import sys
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("scenarios", "controller", "planner", "tissue_sim")
MAX_FILES = 20  # in a folder, besides its __init__.py
KNOW_THE_WORLD = (  # expert and scripted planner, and the robot's own driver and filter
    "controller.driver",
    "controller.expert",
    "controller.links",
    "controller.safety",
    "planner.procedure.outcomes",
    "planner.scripted",
)
OPEN_TO_ALL = (  # modules of the simulator: observations, the robot, and constants
    "tissue_sim.cached_files",  # writes what it is given
    "tissue_sim.constants",
    "tissue_sim.frames",
    "tissue_sim.outcome.clip_rule",
    "tissue_sim.patient.at_risk",  # usual radii, the same for every patient
    "tissue_sim.patient.tube_names",
    "tissue_sim.read_only",
    "tissue_sim.sensing.glance",
    "tissue_sim.sensing.observation",
    "tissue_sim.sensing.picture_faults",
    "tissue_sim.sensing.polyline",
    "tissue_sim.sensing.rest_frame",
    "tissue_sim.sensing.rest_length",
    "tissue_sim.sensing.tube_rule",
    "tissue_sim.sensing.sensor_model",
    "tissue_sim.sensing.tissue_features",
    "tissue_sim.sensing.tracker",
    "tissue_sim.thresholds",
    "tissue_sim.tools.",
)


def test_the_import_contracts_hold():
    """Check the contracts in pyproject.toml: imports go one way, ManiSkill is in one file only."""
    lint = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    check = subprocess.run(
        [sys.executable, "-c", lint, "--no-cache"], cwd=ROOT, capture_output=True, text=True
    )
    assert check.returncode == 0, check.stdout + check.stderr


def test_no_module_imports_itself_through_others():
    """Count also imports for type checkers only, and imports inside functions."""
    graph = grimp.build_graph(*PACKAGES, exclude_type_checking_imports=False, cache_dir=None)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_no_two_public_classes_share_a_name():
    names = Counter(
        node.name
        for package in PACKAGES
        for file in (ROOT / package).rglob("*.py")
        for node in ast.parse(file.read_text()).body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert not {name for name, count in names.items() if count > 1}


@pytest.mark.parametrize("top", [*PACKAGES, "tests"])
def test_no_folder_holds_too_many_files(top: str):
    files = [file for file in (ROOT / top).rglob("*.py") if file.name != "__init__.py"]
    folders = Counter(str(file.parent.relative_to(ROOT)) for file in files)
    assert {folder: n for folder, n in folders.items() if n > MAX_FILES} == {}


def test_policies_but_the_privileged_import_nothing_that_knows_the_world():
    """Follow all chains of imports, also those for type checkers."""
    graph = grimp.build_graph("controller", "planner", "tissue_sim", cache_dir=None)
    own = {name for name in graph.modules if not name.startswith("tissue_sim")}
    told = {name for name in own if not _is_in(name, KNOW_THE_WORLD)}
    closed = {name: _closed(graph.find_upstream_modules(name)) for name in own}
    assert {name: closed[name] for name in told if closed[name]} == {}
    for privileged in KNOW_THE_WORLD:  # none is listed in vain
        assert any(closed[name] for name in own if _is_in(name, (privileged,)))


def _is_in(name: str, packages: tuple[str, ...]) -> bool:
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def _closed(names: set[str]) -> list[str]:
    within = (name for name in names if name.startswith("tissue_sim."))
    return sorted(name for name in within if not name.startswith(OPEN_TO_ALL))
