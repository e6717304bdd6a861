"""What a result was made with."""

import platform
from importlib.metadata import PackageNotFoundError, version

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
    """Returns the version of Python and of each package that can change a result."""
    return {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
