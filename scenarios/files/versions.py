"""The versions of all parts on which a result depends."""

import platform
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = (
    "calot",
    "mani-skill",
    "sapien",
    "warp-lang",
    "torch",
    "onnxruntime",
    "tokenizers",
    "casadi",
    "python-fcl",
    "numpy",
    "scipy",
    "trimesh",
    "viser",
)


EPISODE_SOURCES = (
    "tissue_sim",
    "planner",
    "controller",
    "scenarios/perturbation",
    "scenarios/catalogue.py",
    "scenarios/suites.py",
    "scenarios/episode.py",
    "scenarios/run_episode.py",
    "scenarios/loop",
)
"""Code, word lists and weights that determine an episode's result."""
SUFFIXES = (".py", ".toml", ".safetensors")


@cache
def source_digest() -> str:
    """Return a hash of the sources that determine an episode's result."""
    root = Path(__file__).parents[2]
    files = [f for name in EPISODE_SOURCES for f in _sources(root / name)]
    contents = (f"{f.relative_to(root)}\n".encode() + f.read_bytes() for f in files)
    return sha256(b"\0".join(contents)).hexdigest()[:12]


def _sources(path: Path) -> list[Path]:
    files = path.rglob("*") if path.is_dir() else [path]
    return sorted(file for file in files if file.suffix in SUFFIXES)


def versions() -> dict[str, str]:
    """Return the processor and the versions of Python and of packages that can change a result."""
    return {
        "python": platform.python_version(),
        **{name: _version(name) for name in PACKAGES},
        "processor": _processor(),
    }


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.machine())


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
