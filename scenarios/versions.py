"""What a result was made with."""

import platform
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


def versions() -> dict[str, str]:
    """Returns the version of Python and of each package that can change a result.

    And the processor, as code is compiled for it.
    """
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
