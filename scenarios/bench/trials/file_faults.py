"""Files to tamper with: recordings, evaluations, checkpoints, scripts, data sets, world states."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from controller.dataset.dataset_episode import DatasetEpisode, Header
from controller.dataset.part import part_bytes, read_part
from controller.dataset.schema import demonstrated
from controller.dataset.tables import strings
from controller.diffusion.config import PolicyConfig
from controller.diffusion.policy import CHECKPOINTS as CONTROLLERS
from controller.diffusion.policy import Policy
from planner.learned.network import CHECKPOINTS as PLANNERS
from planner.learned.network import PlannerConfig, PlannerNetwork
from planner.learning.checkpoint import HASH as CHECKPOINT_HASH
from planner.learning.checkpoint import Checkpoints
from scenarios.bench.trials.tampering import Target, flipped, restructured
from scenarios.evaluation.arm import arm_from_text
from scenarios.evaluation.audit import audit
from scenarios.evaluation.case import attempt
from scenarios.evaluation.folder import finished, note, open_folder
from scenarios.evaluation.plan import Plan
from scenarios.files.sums import MANIFEST, SUMS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.script import read_script
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.first_difference import BY_THE_CLOCK
from scenarios.recording.recorder import HASH, HEADER, Recording, load, recording_bytes
from scenarios.recording.verify import verify
from scenarios.suites import suite_of
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.state_tensors import REST, flat, state_from_tensors, state_to_tensors
from tissue_sim.world import World

IDLE = EpisodeConfig(
    planner="scripted",
    controller="idle",
    sense="exact",
    scenario="textbook",
    seed=10_008,
    task_cap_s=0.1,
)
BY_STRUCTURE = 0.6  # of the inputs; the bytes of the others are flipped
NUMBERS = (np.nan, np.inf, -1.0, 0.0, 7.0, 99.0, 1e308)


def recording(folder: Path) -> Target:
    """Return a recording of a few steps, and `calot replay --verify`."""
    attempt_episode(IDLE, folder)
    file = folder / "episodes" / f"{IDLE.seed}.npz"
    good, content = load(file), file.read_bytes()

    def read() -> Recording:
        read = load(file)
        verdict = verify(file)
        if verdict.outcome != "identical":
            raise ValueError(verdict.remark)
        return read

    return Target(
        tamper=lambda chance: _write_recording(file, content, chance),
        read=read,
        is_changed=lambda read: _result(read.result) != _result(good.result),
    )


def _result(result: dict[str, Any] | None) -> dict[str, Any]:
    """Return a result without the fields that depend on the speed of the machine."""
    return {name: value for name, value in (result or {}).items() if name not in BY_THE_CLOCK}


def _write_recording(file: Path, good: bytes, chance: np.random.Generator) -> None:
    """Flip bytes, or edit the parts; an edited recording gets a hash that fits."""
    file.write_bytes(good)
    if chance.random() > BY_STRUCTURE:
        file.write_bytes(flipped(good, chance))
        return
    with np.load(file) as parts:
        header = json.loads(str(parts[HEADER]))
        arrays = {name: parts[name].copy() for name in parts if name not in (HEADER, HASH)}
    if chance.random() < 0.7:
        header = restructured(header, chance)
    else:
        _edit_array(arrays, chance)
    file.write_bytes(recording_bytes(header, arrays))


def _edit_array(arrays: dict[str, np.ndarray], chance: np.random.Generator) -> None:
    name = sorted(arrays)[chance.integers(len(arrays))]
    array, number = arrays[name], NUMBERS[chance.integers(len(NUMBERS))]
    match chance.integers(6):
        case 0:
            del arrays[name]
        case 1:
            arrays[name] = array[: chance.integers(len(array))]
        case 2:
            arrays[name] = array.astype(("<f4", ">f8", "<i4", "<U8")[chance.integers(4)])
        case 3:
            arrays[name] = array[::-1].copy()
        case _ if array.dtype.kind == "i":
            array[chance.integers(len(array))] = int(np.clip(np.nan_to_num(number), -9, 99))
        case _:
            array[chance.integers(len(array))] = number


def evaluation(folder: Path) -> Target:
    """Return an evaluation of two patients who need a person, and the command that resumes it."""
    arm = arm_from_text("first=scripted+idle,sense=exact")
    plan = Plan(arms=(arm,), suites=(suite_of("short-duct"),), seeds=range(10_000, 10_002))
    open_folder(folder, plan.arms)
    for case in plan.due({}):
        attempt(case, folder)
        note(folder, case)
    good = finished(folder, plan)
    names = [MANIFEST, SUMS, *(str(case.recording) for case in good)]
    contents = {folder / name: (folder / name).read_bytes() for name in names}

    def tamper(chance: np.random.Generator) -> None:
        for path, content in contents.items():
            path.write_bytes(content)
        name = names[chance.integers(len(names))]
        path = folder / name
        if name.endswith(".npz"):
            _write_recording(path, contents[path], chance)
        elif name == MANIFEST and chance.random() < BY_STRUCTURE:
            path.write_text(json.dumps(restructured(json.loads(contents[path]), chance)))
        else:
            path.write_bytes(flipped(contents[path], chance))

    def read() -> Any:
        open_folder(folder, plan.arms)
        found = finished(folder, plan)
        audit(folder, found)
        return found

    return Target(
        tamper=tamper,
        read=read,
        is_changed=lambda found: any(good[case] != result for case, result in found.items()),
    )


def _checkpoint(file: Path, checkpoints: Checkpoints[Any, Any]) -> Target:
    content, good = file.read_bytes(), checkpoints.load(file).state_dict()
    with safe_open(file, "pt") as opened:
        said = opened.metadata()
    del said[CHECKPOINT_HASH]
    weights = {name: weight.clone() for name, weight in load_file(file).items()}  # no map of it

    def tamper(chance: np.random.Generator) -> None:
        if chance.random() > BY_STRUCTURE:
            file.write_bytes(flipped(content, chance))
            return
        name = ("config", "fits")[chance.integers(2)]
        edited = said | {name: json.dumps(restructured(json.loads(said[name]), chance))}
        spoilt = dict(weights)
        if chance.random() < 0.3:
            name = sorted(weights)[chance.integers(len(weights))]
            number = NUMBERS[chance.integers(2)]
            spoilt[name] = torch.full_like(weights[name].double(), number)
        save_file(spoilt, file, edited)

    def is_changed(model: Any) -> bool:
        return any(not torch.equal(good[name], w) for name, w in model.state_dict().items())

    return Target(tamper=tamper, read=lambda: checkpoints.load(file), is_changed=is_changed)


def planner(folder: Path) -> Target:
    """Return a small planner's checkpoint."""
    PLANNERS.save(folder / "planner", PlannerNetwork(PlannerConfig(width=16, layers=1)))
    return _checkpoint(folder / "planner", PLANNERS)


def controller(folder: Path) -> Target:
    """Return a small controller's checkpoint."""
    policy = Policy(PolicyConfig(condition_width=8, denoiser_width=8))
    CONTROLLERS.save(folder / "controller", policy)
    return _checkpoint(folder / "controller", CONTROLLERS)


def script(folder: Path) -> Target:
    """Return a script of `--instruct`; a changed text is another script, which is no fault."""
    lines = ["0.5\tmove right arm higher", '{"time_s": 1.5, "text": "stop"}', "2\tgo on"]
    content = "\n".join(lines).encode()

    def tamper(chance: np.random.Generator) -> None:
        entry = json.dumps(restructured(json.loads(lines[1]), chance)).encode()
        is_text = chance.random() > BY_STRUCTURE
        (folder / "script").write_bytes(flipped(content, chance) if is_text else entry)

    return Target(
        tamper=tamper, read=lambda: read_script(folder / "script"), is_changed=lambda read: False
    )


def dataset(folder: Path) -> Target:
    """Return an episode of a data set."""
    chance = np.random.default_rng(0)
    columns: dict[str, Any] = {}
    for name, feature in demonstrated(()).items():
        numbers = chance.normal(size=feature.shape(5))
        text = feature.dtype == "string"
        columns[name] = strings(["a"] * 5) if text else numbers.astype(feature.dtype)
    header = Header(
        seed=1, kind="nominal", scenario="nominal", success=True, failures=(), anatomy={},
        versions={}, cameras=(),
    )  # fmt: skip
    file = folder / "part.parquet"
    file.write_bytes(content := part_bytes(DatasetEpisode(header=header, columns=columns)))
    good = read_part(file)

    def is_changed(read: DatasetEpisode) -> bool:
        same = all(
            np.array_equal(read.columns[name], column) for name, column in good.columns.items()
        )
        return not same or asdict(read.header) != asdict(good.header)

    return Target(
        tamper=lambda chance: file.write_bytes(flipped(content, chance)),
        read=lambda: read_part(file),
        is_changed=is_changed,
    )


def state(folder: Path) -> Target:
    """Return a world's saved state; another possible state is no fault."""
    world = World()
    world.reset(anatomy_from_seed(10_003))
    whole = {"anatomy": world.anatomy, "world": world.state()}
    good = {name: tensor.numpy() for name, tensor in flat(state_to_tensors(whole)).items()}
    given: dict[str, np.ndarray] = {}

    def tamper(chance: np.random.Generator) -> None:
        given.clear()
        given.update(good)
        name = sorted(good)[chance.integers(len(good))] if chance.random() < 0.6 else REST
        array = good[name]
        if name == REST and chance.random() < BY_STRUCTURE:
            given[name] = _restructured_rest(array, chance)
        elif len(edited := flipped(array.tobytes(), chance)) == array.nbytes:
            given[name] = np.frombuffer(edited, array.dtype).reshape(array.shape)
        else:
            del given[name]

    def read() -> None:
        state = state_from_tensors(given)
        world.check(state["world"], state["anatomy"])

    return Target(tamper=tamper, read=read, is_changed=lambda read: False)


def _restructured_rest(block: np.ndarray, chance: np.random.Generator) -> np.ndarray:
    """Return a state's block of bytes (1, n) with the JSON in it edited."""
    text, _, differences = zlib.decompressobj().decompress(block.tobytes()).partition(b"\0")
    tree = restructured(json.loads(text), chance)
    data = zlib.compress(json.dumps(tree).encode() + b"\0" + differences)
    return np.frombuffer(data.ljust(block.size, b"\0"), np.uint8)[None]


FILES: dict[str, Callable[[Path], Target]] = {
    make.__name__: make
    for make in (recording, evaluation, planner, controller, script, dataset, state)
}
"""The functions that make each target in a folder of its own; a new target is one more entry."""
