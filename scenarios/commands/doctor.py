"""`calot doctor`: show the abilities of this machine."""

import json
import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import find_spec

from rich.table import Table

from scenarios.files.outside_text import Terminal, output
from scenarios.files.versions import versions

# Runs in a separate process: both imports take seconds, and a broken driver may crash it.
_CUDA_ATTEMPT = """
import json, torch, warp
warp.config.quiet = True
print(json.dumps({"torch": torch.cuda.is_available(), "warp": warp.get_cuda_device_count() > 0}))
"""

EXTRAS = {"lerobot": "lerobot", "cluster": "ray", "browser": "playwright"}
"""The package of each extra of pyproject.toml that adds something to use."""

_RENDERERS = {
    "gpu": "yes: a GPU",
    "system": "yes: the system's software renderer",
    "private": "yes: the software renderer that `make cameras` fetched",
    None: "no: camera views and --video are off. `make cameras` fetches a software renderer, "
    "without root, on Debian and Ubuntu; elsewhere install Mesa's lavapipe, version 24.3 or later",
}


@dataclass(frozen=True, kw_only=True)
class Doctor:
    """Show what this machine can do, and what to install for more."""

    def execute(self) -> int:
        """Probe and report; return 0."""
        with Terminal(stderr=True).status("looking at this machine"):
            findings = {**_machine(), **versions(), **_extras(), **_accelerators()}
        table = Table(show_header=False)
        for name, finding in findings.items():
            table.add_row(name, finding)
        output().print(table)
        return 0


def _machine() -> dict[str, str]:
    memory_bytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "cores": str(len(os.sched_getaffinity(0))),
        "memory": f"{memory_bytes / 2**30:.1f} GiB",
    }


def _extras() -> dict[str, str]:
    missing = "no: .venv/bin/pip install -e '.[{}]'"
    return {
        f"extra {name}": "yes" if find_spec(package) else missing.format(name)
        for name, package in EXTRAS.items()
    }


def _accelerators() -> dict[str, str]:
    from tissue_sim.rendering.renderer import renderer_kind

    return {
        "renderer": _RENDERERS[renderer_kind()],
        **{f"CUDA for {name}": finding for name, finding in _cuda().items()},
    }


def _cuda() -> dict[str, str]:
    probe = subprocess.run([sys.executable, "-c", _CUDA_ATTEMPT], capture_output=True, text=True)
    if probe.returncode != 0:
        reason = (probe.stderr.strip().splitlines() or [f"exit code {probe.returncode}"])[-1]
        return dict.fromkeys(("torch", "warp"), f"unknown: {reason}")
    found = json.loads(probe.stdout.splitlines()[-1])
    return {
        name: "yes" if there else "no: everything runs on the CPU" for name, there in found.items()
    }
