"""Tests of the installed package: its metadata, and a wheel that works in another folder."""

import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

from scenarios.cli import main
from scenarios.loop.episode_config import EpisodeConfig

ROOT = Path(__file__).parents[1]


def test_calot_says_its_version(capsys):
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == f"calot {declared}" == f"calot {version('calot')}"


def test_every_dependency_has_a_lower_bound():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert [name for name in project["dependencies"] if ">=" not in name and "==" not in name] == []


@pytest.mark.slow
def test_a_wheel_works_from_another_directory(tmp_path):
    """Run an episode of the default stack from the wheel, which holds its weights and tables."""
    built = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    subprocess.run([*built, "--wheel-dir", tmp_path, ROOT], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("calot-*.whl")
    site = tmp_path / "site"
    installed = [sys.executable, "-m", "pip", "install", "--no-deps", "--target", site, wheel]
    subprocess.run(installed, check=True, capture_output=True)
    program = (
        f"import sys; sys.path.insert(0, {str(site)!r})\n"
        "import scenarios\n"
        f"assert scenarios.__file__.startswith({str(site)!r}), scenarios.__file__\n"
        "from scenarios.loop.episode_config import EpisodeConfig\n"
        "from scenarios.run_episode import run_episode\n"
        "result = run_episode(EpisodeConfig(seed=10_002, task_cap_s=1.0))\n"
        "print(result.controller, result.error)\n"
    )
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    run = subprocess.run(
        [sys.executable, "-c", program],
        cwd=elsewhere,
        env={"PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.stdout.strip().splitlines()[-1] == f"{EpisodeConfig.controller} None", run.stderr
