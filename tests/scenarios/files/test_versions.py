"""Tests of what an evaluation folder is bound to: all that decides an episode's result."""

from pathlib import Path

import grimp

from scenarios.files.versions import EPISODE_SOURCES

ROOT = Path(__file__).parents[3]
ASIDE = "scenarios.files."  # writing and reading files decides nothing


def test_the_digest_covers_every_module_that_an_episode_imports():
    packages = ("scenarios", "controller", "planner", "tissue_sim")
    graph = grimp.build_graph(*packages, cache_dir=None)
    imported = graph.find_upstream_modules("scenarios.run_episode") | {"scenarios.run_episode"}
    sources = tuple(ROOT / name for name in EPISODE_SOURCES)
    files = {name: ROOT.joinpath(*name.split(".")).with_suffix(".py") for name in imported}
    outside = [
        name
        for name, file in files.items()
        if file.exists() and not any(file.is_relative_to(source) for source in sources)
    ]
    assert len(files) > 100
    assert [name for name in outside if not name.startswith(ASIDE)] == []
