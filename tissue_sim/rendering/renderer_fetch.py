"""Fetch Mesa's software renderer from this machine's own package sources, without root.

`make cameras` runs this file. Nothing outside the environment's folder is written. The program apt
works on private lists and a private cache. Packages are unpacked in the folder instead of
installed. Mesa before 24.3 does not suffice, so the backports of the machine's release are used
too, at the same address.
"""

import json
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tissue_sim.rendering.renderer import (
    DRIVER,
    LIBRARIES,
    PRIVATE_FOLDER,
    choice_of_another,
    renderer_kind,
)

PACKAGE = "mesa-vulkan-drivers"
DRIVER_LIBRARY = "libvulkan_lvp.so"
BASE = r"libc6|libgcc-s1|libstdc\+\+6|gcc-\d+-base|libcrypt1"  # Python and SAPIEN have loaded them
PROGRAMS = ("apt-get", "dpkg", "ldd")
APT = Path("/etc/apt")
DPKG_STATUS = Path("/var/lib/dpkg/status")

# Limits of waiting (s), assumed: a machine without network must not be kept waiting.
ANSWER_S = 10
UPDATE_S = 60
DOWNLOAD_S = 600
UNPACK_S = 120  # per package

APT_SETTINGS = """
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
Dir::Etc::SourceList "/dev/null";
Dir::Etc::SourceParts "{root}/sources";
Dir::State "{root}/state";
Dir::State::Lists "{root}/state/lists";
Dir::State::Status "{root}/status";
Dir::Cache "{root}/cache";
Dir::Cache::Archives "{root}/cache/archives";
Debug::NoLocking "true";
APT::Sandbox::User "";
APT::Install-Recommends "false";
Acquire::Languages "none";
Acquire::Retries "1";
Acquire::http::Timeout "{answer_s}";
Acquire::https::Timeout "{answer_s}";
"""


class FetchError(Exception):
    """No renderer can be fetched here; the message states the reason in one line."""


def backports(sources: str, codename: str) -> str:
    """Return package sources with the release's own suite replaced by its backports.

    Args:
        sources: The text of a file of `/etc/apt`, with one line or one stanza per source.
        codename: The release's name, such as "bookworm".

    Returns:
        The sources of the backports; empty if the text names no source of this release.
    """
    line = rf"^(deb\s+(?:\[[^\]]*\]\s+)?\S+\s+){codename}(\s.*)$"
    found = [f"{m[1]}{codename}-backports{m[2]}" for m in re.finditer(line, sources, re.M)]
    suites = rf"^Suites:(?:.*\s){codename}(?:\s.*)?$"
    for stanza in re.split(r"\n\s*\n", sources):
        if re.search(suites, stanza, re.M) and re.search(r"^Types:.*\bdeb\b", stanza, re.M):
            found.append(re.sub(suites, f"Suites: {codename}-backports", stanza, flags=re.M))
    return "\n\n".join(text.strip() for text in found)


def fetch(folder: Path = PRIVATE_FOLDER) -> None:
    """Put the renderer in `folder`, in place of its content.

    Raises:
        FetchError: this machine has no apt, its sources cannot be reached or have no renderer, or a
            file cannot be read or written.
    """
    if missing := [name for name in PROGRAMS if shutil.which(name) is None]:
        raise FetchError(f"only Debian and its like are served, and {missing[0]} is not here")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=folder.parent, prefix=".renderer-") as name:
            root = Path(name)
            for package in _downloaded(root):
                unpacking = _run(["dpkg", "-x", str(package), f"{root}/unpacked"], UNPACK_S)
                if unpacking.returncode != 0:
                    why = _complaint(unpacking.stderr)
                    raise FetchError(f"{package.name} cannot be unpacked: {why}")
            _arrange(root / "unpacked", root / "renderer")
            shutil.rmtree(folder, ignore_errors=True)
            (root / "renderer").rename(folder)
    except OSError as error:
        raise FetchError(f"{error.filename or folder}: {error.strerror or error}") from error


def _downloaded(root: Path) -> list[Path]:
    """Download the driver's package and all its dependencies beyond `BASE`."""
    codename = platform.freedesktop_os_release().get("VERSION_CODENAME", "")
    for made in ("sources", "state/lists/partial", "cache/archives/partial"):
        (root / made).mkdir(parents=True)
    _write_sources(root / "sources", codename)
    (root / "status").write_text(_base_of(DPKG_STATUS.read_text()))
    settings = root / "apt.conf"
    settings.write_text(APT_SETTINGS.format(root=root, answer_s=ANSWER_S))
    apt = ["apt-get", "-c", str(settings), "-qq", "-y"]
    suite = ["--target-release", f"{codename}-backports"]
    updated = _run([*apt, "update"], UPDATE_S)
    download = _run([*apt, "install", "--download-only", *suite, PACKAGE], DOWNLOAD_S)
    if download.returncode != 0:
        raise FetchError(f"apt-get: {_complaint(updated.stderr + download.stderr)}")
    return sorted((root / "cache/archives").glob("*.deb"))


def _write_sources(folder: Path, codename: str) -> None:
    """Write the machine's package sources, and the backports below them."""
    found = False
    for file in (APT / "sources.list", *sorted((APT / "sources.list.d").glob("*"))):
        if file.suffix in (".list", ".sources") and os.access(file, os.R_OK):
            more = backports(text := file.read_text(), codename)
            (folder / file.name).write_text(f"{text}\n\n{more}\n")
            found |= bool(more)
    if not found:
        raise FetchError(f"no package source of the release {codename!r} in {APT}")


def _base_of(status: str) -> str:
    """Return the part of dpkg's list of installed packages that is never fetched.

    All other dependencies of the driver are fetched, including those installed in an older version.
    """
    base = re.compile(rf"Package: (?:{BASE})\n")
    return "".join(f"{text}\n\n" for text in status.split("\n\n") if base.match(text))


def _arrange(unpacked: Path, folder: Path) -> None:
    """Copy the driver and its dependencies to `folder`; write its description and library list."""
    everything = unpacked / "everything"
    everything.mkdir()
    files = {file.name: file for file in unpacked.rglob("*.so*")}
    for name, file in files.items():
        (everything / name).symlink_to(file)
    if not (everything / DRIVER_LIBRARY).exists():
        raise FetchError(f"the package {PACKAGE} holds no {DRIVER_LIBRARY}")
    # A library's dependencies are a part of its user's, so their number gives the order of loading.
    names = sorted(
        _needs(everything / DRIVER_LIBRARY), key=lambda name: len(_needs(everything / name))
    )
    (folder / "lib").mkdir(parents=True)
    for name in (*names, DRIVER_LIBRARY):
        shutil.copyfile(everything / name, folder / "lib" / name)
    (folder / LIBRARIES).write_text("".join(f"lib/{name}\n" for name in names))
    driver = {"library_path": f"./lib/{DRIVER_LIBRARY}", "api_version": "1.3.0"}
    (folder / DRIVER).write_text(json.dumps({"file_format_version": "1.0.0", "ICD": driver}))


def _needs(library: Path) -> set[str]:
    """Return the names of a library's dependencies that are in the library's own folder."""
    environment = os.environ | {"LD_LIBRARY_PATH": str(library.parent)}
    listed = subprocess.run(["ldd", library], env=environment, capture_output=True, text=True)
    return set(re.findall(rf"=> {re.escape(str(library.parent))}/(\S+)", listed.stdout))


def _run(command: list[str], limit_s: float) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=limit_s)
    except subprocess.TimeoutExpired as error:
        raise FetchError(f"{command[0]} was not done in {limit_s:.0f} s") from error


def _complaint(said: str) -> str:
    """Return the first line of a program's output that states an error; later lines follow."""
    lines = said.splitlines() or ["it failed and did not say why"]
    stated = [line[3:] for line in lines if "Failed to fetch" in line or line[:2] == "E:"]
    return (stated or lines)[0]


def fetch_if_needed() -> str:
    """Fetch a renderer if none works here; return what was done.

    Raises:
        FetchError: no renderer works afterwards.
    """
    if (kind := renderer_kind()) is not None:
        return f"A renderer works here ({kind}); nothing to fetch."
    if (variable := choice_of_another()) is not None:
        raise FetchError(f"{variable} names a driver that does not work")
    print("Fetching Mesa's software renderer (about 50 MB) ...", flush=True)
    fetch()
    renderer_kind.cache_clear()
    if renderer_kind() is None:
        shutil.rmtree(PRIVATE_FOLDER)
        raise FetchError("the one in the package sources does not work with SAPIEN")
    return f"The renderer is in {PRIVATE_FOLDER}."


if __name__ == "__main__":
    try:
        print(fetch_if_needed())
    except FetchError as error:
        sys.exit(f"No renderer: {error}.")
