"""Tests of README, docs and notebooks: commands parse, links and names exist, examples run."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from itertools import islice, pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from controller.diffusion.rules.chunk_rules import RULES as CHUNK_RULES
from planner.learned.planner import RULES as PLANNER_RULES
from planner.policy_setup import PolicySetup
from scenarios.cli import main, parse
from scenarios.files.errors import BadInputError
from tissue_sim import thresholds

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "AGENTS.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
PACKAGES = ("tissue_sim", "planner", "controller", "scenarios")

README_LINES, README_WORDS = 150, 900
NOTEBOOK_BYTES = 400_000

ARCHAIC = (
    "is had",
    "are had",
    "gone on from",
    "whoever",
    "wherefrom",
    "therein",
    "the sooner",
    "comes off by itself",
)

OTHER_PROGRAMS = ("printf", "curl", "ray", ".venv/bin/pip", ".venv/bin/jupyter", "lerobot-train")
MAKE_TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))

_BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
_ASSIGNMENT = re.compile(r'([A-Z][A-Z_]*)=("[^"]*"|[^\s;]*)(?:;\s*|\s+|$)')


def _blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a page that are marked with this language."""
    return [
        re.sub(f"^{indent}", "", code, flags=re.MULTILINE)
        for indent, name, code in _BLOCK.findall(page.read_text())
        if name == language
    ]


def _prose(page: Path) -> str:
    """Return a page without its code blocks."""
    return _BLOCK.sub("", page.read_text())


def _commands(block: str) -> Iterator[list[str]]:
    """Yield the words of each command of a shell block.

    `NAME=value` before a command is removed. If no command follows, it is kept, and a later `$NAME`
    is replaced by the value.
    """
    known: dict[str, str] = {}
    for line in block.replace("\\\n", " ").splitlines():
        left, given = re.sub(r"(^|\s)#.*", "", line).strip(), {}
        while match := _ASSIGNMENT.match(left):
            given[match[1]] = _expanded(match[2].strip('"'), known)
            left = left[match.end() :]
            known |= given if not left or _ASSIGNMENT.match(left) else {}
        if left:
            yield shlex.split(_expanded(left, known))


def _expanded(text: str, known: dict[str, str]) -> str:
    return re.sub(r"\$([A-Z][A-Z_]*)", lambda match: known[match[1]], text)


def _all_commands() -> list[tuple[str, list[str]]]:
    return [
        (page.name, command)
        for page in PAGES
        for block in _blocks(page, "sh")
        for command in _commands(block)
    ]


def test_shell_variables_are_replaced_by_the_rule():
    block = (
        'D=a/b; C="calot run --out $D"\n$C --seed 3  # a remark\nKEY=x calot view \\\n  --start\n'
    )
    assert list(_commands(block)) == [
        ["calot", "run", "--out", "a/b", "--seed", "3"],
        ["calot", "view", "--start"],
    ]


def test_every_command_in_readme_and_docs_parses(monkeypatch, tmp_path):
    (tmp_path / "my_policy.py").write_text(_own_policies())
    monkeypatch.syspath_prepend(tmp_path)
    found = _all_commands()
    assert len(found) > 60
    for page, (program, *words) in found:
        if program == ".venv/bin/calot":
            _parse(page, words)
        elif program == "make":
            assert set(words) <= MAKE_TARGETS, (page, words)
        elif program == ".venv/bin/python":
            assert words[0] == "-m", (page, words)
            assert find_spec(words[1]) is not None, (page, words)
        else:
            assert program in OTHER_PROGRAMS, (page, program, words)


def _parse(page: str, words: list[str]) -> None:
    if words == ["--version"]:
        assert main(words) == 0
        return
    try:
        with pytest.raises(SystemExit) if "--help" in words else nullcontext():
            parse(words)
    except BadInputError as error:
        raise AssertionError(f"{page}: calot {shlex.join(words)}: {error}") from error


def test_commands_in_prose_exist():
    """Check that `calot NAME` in backticks names a command, and `make NAME` a target."""
    for page in (*PAGES, ROOT / "CHANGELOG.md"):
        for code in re.findall(r"`([^`\n]+)`", _prose(page)):
            words = shlex.split(code) if code.startswith(("calot ", "make ")) else []
            if words[:1] == ["make"]:
                assert words[1] in MAKE_TARGETS, (page.name, code)
            elif len(words) == 2 and not words[1].startswith("-"):
                with pytest.raises(SystemExit) as stop:
                    parse([words[1], "--help"])
                assert stop.value.code == 0, (page.name, code)


def test_links_resolve():
    for page in (*PAGES, ROOT / "CHANGELOG.md"):
        for target in re.findall(r"\]\(([^)\s]+)\)", _prose(page)):
            if target.startswith(("http://", "https://")):
                continue
            name, _, anchor = target.partition("#")
            file = page.parent / name if name else page
            assert file.exists(), (page.name, target)
            assert not anchor or anchor in _anchors(file), (page.name, target)


def _anchors(page: Path) -> set[str]:
    """Return what the headings of a page are called in links."""
    headings = re.findall(r"^#+ (.+)$", _prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\s-]", "", h).strip().lower().replace(" ", "-") for h in headings}


def test_files_and_modules_in_backticks_exist():
    """Check paths in the repository, names of Python files, and dotted paths of modules."""
    names = {path.name for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    for page in (*PAGES, ROOT / "CHANGELOG.md"):
        for code in re.findall(r"`([^`\n]+)`", _prose(page)):
            if code.startswith(tuple(f"{package}/" for package in PACKAGES)):
                assert (ROOT / code).exists(), (page.name, code)
            elif re.fullmatch(r"[\w-]+\.py", code) and code != "my_policy.py":
                assert code in names, (page.name, code)
            elif re.fullmatch(rf"(?:{'|'.join(PACKAGES)})(?:\.\w+)+", code):
                assert _is_in_a_module(code.split(".")), (page.name, code)


def _is_in_a_module(parts: list[str]) -> bool:
    """Return whether a dotted path is a module or a name that a module defines."""
    if _module(parts) is not None:
        return True
    source = _module(parts[:-1])
    return source is not None and re.search(rf"\b{parts[-1]}\b", source.read_text()) is not None


def _module(parts: list[str]) -> Path | None:
    path = ROOT.joinpath(*parts)
    return next((p for p in (path.with_suffix(".py"), path / "__init__.py") if p.exists()), None)


def test_names_in_the_table_of_the_architecture_are_in_their_files():
    text = (ROOT / "docs/architecture.md").read_text()
    rows = re.findall(r"^\| [^|]+\? \| ([^|]+) \| ([^|]*) \|$", text, re.MULTILINE)
    assert len(rows) >= 12
    for files, names in rows:
        sources = [ROOT / f for f in re.findall(r"`([^`]+)`", files)]
        code = "\n".join(f.read_text() for f in sources if f.is_file())
        for name in re.findall(r"`([\w.]+)`", names):
            assert all(re.search(rf"\b{part}\b", code) for part in name.split(".")), (files, name)


def test_every_room_is_in_the_architecture_with_its_question():
    text = (ROOT / "docs/architecture.md").read_text()
    listed = set(re.findall(r"^\| `([\w/]+)/` \| .+\? \|$", text, re.MULTILINE))
    rooms = {
        path.parent.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("__init__.py")
    }
    assert listed == rooms


def test_every_rule_is_on_the_page_of_rules_with_its_use():
    rows = re.findall(r"^\| ([^|*]+) \|", (ROOT / "docs/rules.md").read_text(), re.MULTILINE)
    assert {*CHUNK_RULES, *PLANNER_RULES} <= {row.strip() for row in rows}


def test_readme_is_short():
    text = (ROOT / "README.md").read_text()
    assert len(text.splitlines()) <= README_LINES
    assert len(text.split()) <= README_WORDS


def test_readme_and_results_say_what_the_policies_are_told():
    for page in ("README.md", "docs/results.md", "docs/limits.md", "docs/index.md"):
        assert re.search(
            r"(nothing|no policy) sees\s+pictures|sees\s+no\s+pictures", (ROOT / page).read_text()
        ), page


def _own_policies() -> str:
    """Return the Python of README's own policy and that of its page, as one file."""
    pages = ROOT / "README.md", ROOT / "docs/your-own-policy.md"
    blocks = [block for page in pages for block in _blocks(page, "python")]
    return "\n\n".join(block for block in blocks if "def make" in block)


def _module_of(source: str, folder: Path, name: str) -> ModuleType:
    file = folder / f"{name}.py"
    file.write_text(source)
    spec = spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_readmes_own_policy_acts(tmp_path):
    """Run the example as it stands: at each step, both arms do what it asks for."""
    from scenarios.loop.episode_config import EpisodeConfig
    from scenarios.run_episode import begin

    (code,) = (b for b in _blocks(ROOT / "README.md", "python") if "def make" in b)
    assert len(code.splitlines()) <= 14
    policy = _module_of(code, tmp_path, "my_policy").make(PolicySetup(seed=20_000))
    exact = EpisodeConfig(sense="exact")  # as encoders tell, the jaws flicker
    steps = list(islice(begin(exact, controller=policy).steps(), 6))
    assert all(step.asked is not None for step in steps)
    assert max(abs(b.command.joints - a.command.joints).max() for a, b in pairwise(steps)) == 0.0


def test_the_own_policies_of_the_page_move_and_plan(tmp_path):
    from scenarios.loop.episode_config import EpisodeConfig
    from scenarios.run_episode import begin

    made = _module_of(_own_policies(), tmp_path, "my_policies")
    setup = PolicySetup(seed=20_000)
    planner = made.make_planner(setup)
    episode = begin(EpisodeConfig(), planner=planner, controller=made.make(setup))
    tips = [step.observation.tips_endoscope for step in islice(episode.steps(), 30)]
    moved_m = (tips[-1] - tips[0])[:, :3, 3]
    assert moved_m[1, 2] < -0.004  # 30 steps of 0.3 mm towards the surgeon, minus the arms' lag
    assert abs(moved_m[0]).max() < 0.001


def test_the_gym_examples_run():
    """Run README's examples and those of the environment's page, as one program."""
    pages = ROOT / "README.md", ROOT / "docs/environment.md"
    code = "\n".join(block for page in pages for block in _blocks(page, "python"))
    exec(compile(code, "the gym examples", "exec"), {"__name__": "example"})


def test_the_pages_build_and_load_nothing_from_elsewhere(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    build = subprocess.run(
        [*command, "--site-dir", str(tmp_path)], cwd=ROOT, capture_output=True, text=True
    )
    assert build.returncode == 0, build.stderr
    pages = list(tmp_path.rglob("*.html"))
    assert len(pages) > 15
    for page in pages:
        loaded = re.findall(r"<(?:script|link|img|iframe)[^>]+https?://[^>]*>", page.read_text())
        assert not loaded, (page.name, loaded)
        assert 'class="mermaid"' not in page.read_text(), page.name


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_have_clean_small_outputs(path):
    """Check that every code cell was run, in order, without a warning or a path of a machine."""
    cells = [c for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert outputs
    assert path.stat().st_size < NOTEBOOK_BYTES
    for output in outputs:
        assert output["output_type"] != "error"
        assert output.get("name") != "stderr", output["text"]
        texts = [v for k, v in output.get("data", {}).items() if k.startswith("text/")]
        text = str(output.get("text", "")) + str(texts)
        assert not re.search(r"/tmp/|/home/|/root/|site-packages|Warning", text), text


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_end_by_checking(path):
    last = [c for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"][-1]
    assert "assert" in "".join(last["source"])


def test_no_archaic_phrase_is_left():
    """Check pages, Python and notebooks: a reader must understand a sentence at first reading."""
    phrase = re.compile(rf"\b({'|'.join(ARCHAIC)})\b", re.IGNORECASE)
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for path in _texts()
        for match in phrase.finditer(re.sub(r"\W+(?=\w)", " ", path.read_text()))
    ]
    assert not found, "\n".join(found)


def _texts() -> Iterator[Path]:
    """Yield every text that people read, except this file with the list of phrases."""
    yield from ROOT.glob("*.md")
    for folder in (*PACKAGES, "docs", "tests"):
        for kind in ("*.md", "*.py"):
            yield from (p for p in (ROOT / folder).rglob(kind) if p != Path(__file__))
    yield from NOTEBOOKS


UNITS = {"": 1.0, "mm": 1e-3, "deg": np.pi / 180.0, "%": 0.01, "N": 1.0, "s": 1.0, "rad": 1.0}
UNITS |= {"MPa": 1e6, "mm³": 1e-9}


def test_the_docs_list_every_threshold_once_with_its_value_and_source():
    """Check `docs/physics.md` against `tissue_sim/thresholds.py`."""
    text = (ROOT / "tissue_sim" / "thresholds.py").read_text()
    names = re.findall(r"^([A-Z_]+)(?:: [^=]+)? = ", text, re.M)
    rows = re.findall(
        r"^\| `([A-Z_]+)`: [^|]+ \| ([\d.]+) ?([^|]*?) \| [^|]{3,} \|$",
        (ROOT / "docs" / "physics.md").read_text(),
        re.M,
    )
    assert names
    assert sorted(name for name, _, _ in rows) == sorted(names)
    for name, number, unit in rows:
        value = getattr(thresholds, name)
        for each in value.values() if isinstance(value, dict) else [value]:
            assert float(number) * UNITS[unit] == pytest.approx(each), name
