"""Tests of training: from a dataset to a moving robot; bad data are refused in one line."""

from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from controller.dataset.choice import Choice
from controller.dataset.merge import merge
from controller.dataset.schema import PICTURE_SHAPE, TEXTS
from controller.diffusion.command import encoded
from controller.diffusion.config import PolicyConfig
from controller.diffusion.demonstrations import demonstrations
from controller.diffusion.policy import CHECKPOINTS
from controller.diffusion.windows import Windows
from controller.pixels.controller import make as pixels
from controller.pixels.policy import CHECKPOINTS as PIXELS
from planner.instruction import CORRECTIONS, TASKS, Instruction
from planner.learned.planner import make as learned
from planner.policy_setup import PolicySetup
from scenarios.cli import main
from scenarios.commands.train import SLOW_BFLOAT16
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tests.controller.dataset.episodes import write_parts
from tests.planner.observations import clipped
from tests.scenarios.from_the_shell.complaint import complaint

SEED = 10_003


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    root = tmp_path_factory.mktemp("data")
    said = np.arange(50) % len(TEXTS)  # each task, and each correction
    merge(write_parts(root / "parts", (0, 1), task_index=said), root)
    return root


@pytest.fixture(scope="module")
def checkpoint(data, tmp_path_factory):
    out = tmp_path_factory.mktemp("trained")
    words = ["train", "controller", "--preset", "smoke", "--data", str(data), "--out", str(out)]
    assert main(words) == 0
    file = out / "policy.safetensors"
    before, written_ns = file.read_bytes(), file.stat().st_mtime_ns
    assert main(words) == 0  # nothing is left to do
    assert (file.read_bytes(), file.stat().st_mtime_ns) == (before, written_ns)
    return out / "policy.safetensors"


def test_a_processor_without_bfloat16_is_named_before_hours_are_lost(data, tmp_path, capsys):
    words = ["train", "controller", "--preset", "smoke", "--steps", "1", "--data", str(data)]
    for option, slow in (("--bfloat16", not has_bfloat16()), ("--no-bfloat16", False)):
        assert main([*words, option, "--out", str(tmp_path / option)]) == 0
        assert (SLOW_BFLOAT16 in capsys.readouterr().err) == slow


def has_bfloat16():
    """Return whether the kernel lists bfloat16 among the processor's instructions."""
    return any("avx512_bf16" in line for line in Path("/proc/cpuinfo").read_text().splitlines())


def commands(checkpoint):
    """Return the joints (n, 2, 7) commanded in an episode's first half second."""
    config = EpisodeConfig(
        scenario="textbook",
        planner="scripted",
        seed=SEED,
        controller="diffusion",
        checkpoint=str(checkpoint),
    )
    return np.array([step.command.joints for step in islice(begin(config).steps(), 15)])


def test_a_trained_policy_moves_the_arms_the_same_each_time(checkpoint):
    first, again = commands(checkpoint), commands(checkpoint)
    np.testing.assert_array_equal(first, again)
    assert np.ptp(first, axis=0).max() > 1e-4


def test_a_controller_learns_from_pictures_and_moves_the_arms(tmp_path, capfd):
    cameras = ("endoscope_left", "wrist_right")
    merge(write_parts(tmp_path / "parts", (0, 1), cameras=cameras), tmp_path)
    words = ["train", "pixels", "--preset", "smoke", "--steps", "20", "--data", str(tmp_path)]
    out = tmp_path / "trained"
    assert main([*words, "--out", str(out)]) == 0
    path = out / "policy.safetensors"
    policy = PIXELS.load(path)
    controller = pixels(PolicySetup(checkpoint=str(path), cameras=cameras))
    images = {name: np.zeros(PICTURE_SHAPE, np.uint8) for name in policy.pixels.cameras}
    chunk = controller.act(replace(clipped(), images=images), Instruction(task=TASKS[0]))
    assert all(np.isfinite(action.vector()).all() for action in chunk)
    _ = capfd.readouterr()
    said = complaint(capfd, "run", "--controller", "pixels", "--checkpoint", str(path))
    assert "name endoscope_left with --cameras" in said
    arm = f"mine=scripted+pixels,checkpoint={path}"
    said = complaint(capfd, "evaluate", "--arms", "scripted+expert", arm)
    assert said.startswith("calot: --arms mine: ,checkpoint=: ")
    assert "name endoscope_left with ,cameras=, too" in said


def test_training_goes_on_from_a_checkpoint_and_keeps_its_normalisation(checkpoint, data, tmp_path):
    words = ["--preset", "smoke", "--data", str(data), "--out", str(tmp_path)]
    assert main(["train", "controller", "--base", str(checkpoint), "--steps", "20", *words]) == 0
    before, after = (load_file(path) for path in (checkpoint, tmp_path / "policy.safetensors"))
    weights = {name for name in before if not torch.equal(before[name], after[name])}
    kept = set(before) - weights
    assert {name for name, _ in CHECKPOINTS.load(checkpoint).named_buffers()} <= kept
    assert {name for name, _ in CHECKPOINTS.load(checkpoint).named_parameters()} <= weights
    anew = tmp_path / "anew"
    assert main(["train", "controller", "--steps", "20", *words[:-1], str(anew)]) == 0
    assert final_loss(tmp_path) < final_loss(anew)


def final_loss(folder):
    """Return the mean loss of the last steps, as TensorBoard has it."""
    curves = EventAccumulator(str(folder / "tensorboard"))
    curves.Reload()
    return np.mean([point.value for point in curves.Scalars("loss")[-5:]])


def test_excluded_data_are_not_learnt_from(data):
    whole, rest = (
        demonstrations([data]),
        demonstrations([data], Choice(leave_out=["recovery", "order"])),
    )
    assert [len(d.task) for d in whole] == [len(d.task) for d in rest]
    with pytest.raises(ValueError, match="nothing to learn"):
        Windows(demonstrations([data], Choice(leave_out=["nominal"])), PolicyConfig())


@pytest.mark.parametrize("goes_on", [False, True])
def test_a_wordless_policy_ignores_all_instructions(goes_on, checkpoint, data, tmp_path):
    words = ["--preset", "smoke", "--steps", "20", "--data", str(data), "--out", str(tmp_path)]
    words += ["--base", str(checkpoint)] * goes_on
    assert main(["train", "controller", "--wordless", *words]) == 0
    config = CHECKPOINTS.load(tmp_path / "policy.safetensors").config
    assert config.wordless
    heard = {int(said) for d in demonstrations([data]) for said in d.heard_by(config).said}
    assert len(heard) == 1
    one, other = (Instruction(task=TASKS[k], correction=CORRECTIONS[k]) for k in (0, 5))
    for name, part in encoded(one, config).items():
        assert torch.equal(part, encoded(other, config)[name])


def test_a_planner_learns_from_rollouts_and_says_a_task(data, tmp_path):
    words = ["train", "planner", "--preset", "smoke", "--data", str(data)]
    assert main([*words, "--out", str(tmp_path)]) == 0
    planner = learned(PolicySetup(checkpoint=str(tmp_path / "planner.safetensors")))
    planner.reset()
    assert planner.plan(clipped()).task in TASKS


def test_a_planner_is_trained_on_the_cpu(capfd):
    assert "allows cpu" in complaint(capfd, "train", "planner", "--device", "cuda")


def test_a_planner_is_never_wordless(capfd):
    assert "--wordless is only for" in complaint(capfd, "train", "planner", "--wordless")


def test_a_share_above_the_whole_is_told_in_one_line(capfd, data):
    said = complaint(capfd, "train", "planner", "--data", str(data), "--share", "2")
    assert "share must be above 0 and at most 1, got 2" in said


def test_no_dataset_is_told_in_one_line(capfd, tmp_path):
    words = ["train", "controller", "--data", str(tmp_path), "--out", str(tmp_path / "out")]
    assert "there is no dataset" in complaint(capfd, *words)


@pytest.mark.parametrize(
    ("controller", "said"),
    [
        ("diffusion", "is no checkpoint of a diffusion policy"),
        ("expert", "controller 'expert' takes none; these do: diffusion"),
    ],
)
def test_a_file_that_is_no_checkpoint_is_told_in_one_line(capfd, tmp_path, controller, said):
    path = tmp_path / "policy.safetensors"
    path.write_text("no weights")
    words = ["run", "--controller", controller, "--checkpoint", str(path)]
    assert said in complaint(capfd, *words, "--out", str(tmp_path / "out"))


@pytest.mark.parametrize("words", [["run", "--controller", "diffusion"], ["bench", "controller"]])
def test_a_checkpoint_that_is_neither_named_nor_shipped_is_told_in_one_line(
    capfd, tmp_path, monkeypatch, words
):
    none = replace(CHECKPOINTS, shipped=tmp_path / "none")
    for module in ("controller.diffusion.policy", "scenarios.bench.controller"):
        monkeypatch.setattr(f"{module}.CHECKPOINTS", none)
    assert "`calot train controller` makes one" in complaint(capfd, *words)


def test_the_bench_times_chunks_and_joins_them_at_each_delay(checkpoint, capsys):
    words = ["--checkpoint", str(checkpoint), "--repeats", "3", "--steps", "30"]
    assert main(["bench", "controller", *words]) == 0
    said = capsys.readouterr().out
    for word in ("ONNX Runtime", "PyTorch, eager", "at joints", "inside"):
        assert word in said
