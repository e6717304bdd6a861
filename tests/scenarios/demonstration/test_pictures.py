"""Laws of labelled pictures: which patients, resumption, and from pictures to a sense."""

from collections import Counter

import numpy as np
import pytest
from safetensors.torch import load_file

from controller.diffusion.policy import CHECKPOINTS
from scenarios.cli import main
from scenarios.commands import collect as collect_command
from scenarios.demonstration import pictures
from scenarios.demonstration.mix import TRAINING_SEEDS
from scenarios.demonstration.pictures import (
    AHEAD,
    STRATA,
    frames_path,
    picture,
    pictured,
    stratum_of,
)
from tests.scenarios.from_the_shell.complaint import complaint
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.sensing.eyes import VIEWS
from tissue_sim.sensing.observation import N_SHOWN


def test_more_episodes_only_add_some():
    assert pictured(0, 40)[:12] == pictured(0, 12)


def test_lengths_are_nearly_equally_frequent():
    """Count patients without a second artery: no one with it is passed over."""
    patients = [anatomy_from_seed(d.seed) for d in pictured(0, 120)]
    counts = Counter(stratum_of(a) for a in patients if a.second_artery is None)
    assert set(counts) == set(STRATA)
    assert max(counts.values()) <= min(counts.values()) + AHEAD + 1


def test_no_second_artery_is_passed_over():
    taken = [d.seed for d in pictured(0, 60)]
    rare = {s for s in range(taken[-1]) if anatomy_from_seed(s).second_artery is not None}
    assert rare
    assert rare <= set(taken)


def test_a_learned_controller_acts_in_every_other_episode():
    taken = pictured(0, 32, "policy.safetensors")
    assert [d.checkpoint for d in taken] == ["", "policy.safetensors"] * 16
    assert [d.is_rollout for d in taken] == [False, True] * 16
    assert [d.seed for d in taken] == [d.seed for d in pictured(0, 32)]
    assert {d.scenario for d in taken if d.is_rollout} > {"nominal"}


def test_only_training_seeds_are_pictured():
    assert pictured(TRAINING_SEEDS.stop - 2, 50)[-1].seed < TRAINING_SEEDS.stop
    assert pictured(TRAINING_SEEDS.stop, 5) == []


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_too_many_pictures_are_refused_in_one_line(tmp_path, capfd):
    words = ["collect", "--pictures", "--seed", "9999", "--episodes", "5", "--out", str(tmp_path)]
    assert "training seeds, 0 to 9999" in complaint(capfd, *words)


@pytest.fixture
def breaking(monkeypatch):
    """Have the second of three episodes break off; return the set of those that do."""
    broken = {pictured(0, 3)[1]}

    def frames(demonstration):
        if demonstration in broken:
            raise RuntimeError("a string snapped")
        yield {"points_m": np.zeros(3)}

    monkeypatch.setattr(pictures, "_frames", frames)
    monkeypatch.setattr(collect_command, "require_renderer", lambda option: None)
    return broken


def collect(out):
    return main(["collect", "--pictures", "--episodes", "3", "--out", str(out)])


def test_an_episode_that_breaks_off_is_told_and_the_others_go_on(tmp_path, breaking, capfd):
    (broken,) = breaking
    assert collect(tmp_path) == 3
    out, err = capfd.readouterr()
    assert f"{broken.name} broke off: RuntimeError: a string snapped\n" in out
    assert "2 episodes, of them 2 new with 2 frames" in out
    assert "Traceback" not in err
    trace = tmp_path / "errors" / f"{broken.name}.txt"
    assert "a string snapped" in trace.read_text()
    breaking.clear()
    assert collect(tmp_path) == 0
    assert "3 episodes, of them 1 new with 1 frames" in capfd.readouterr().out
    assert not trace.exists()


def test_pictures_of_another_world_are_not_joined(tmp_path, breaking, capfd, monkeypatch):
    breaking.clear()
    monkeypatch.setattr(pictures, "WORLD_VERSION", WORLD_VERSION - 1)
    assert collect(tmp_path) == 0
    capfd.readouterr()
    words = ["collect", "--pictures", "--episodes", "3", "--out", str(tmp_path)]
    line = complaint(capfd, *words)
    assert f"is of world version {WORLD_VERSION - 1}, not {WORLD_VERSION}" in line


def test_pictures_by_another_controller_are_not_joined(tmp_path, breaking, capfd):
    breaking.clear()
    other = tmp_path / "other.safetensors"
    other.write_bytes(b"other weights")
    for demonstration in pictured(0, 2, str(other)):
        picture(demonstration, tmp_path / "out")
    words = ["collect", "--pictures", "--episodes", "2", "--out", str(tmp_path / "out")]
    line = complaint(capfd, *words, "--checkpoint", str(CHECKPOINTS.shipped))
    assert line.startswith("calot: --checkpoint: the controller in ")
    assert main(words) == 0  # without a learned controller there is nothing to differ


def test_pictures_that_do_not_tell_how_they_were_made_may_be_continued(tmp_path, breaking):
    breaking.clear()
    np.savez(frames_path(pictured(0, 1)[0], tmp_path), points_m=np.zeros((1, 3)))
    assert collect(tmp_path) == 0
    assert len(list(tmp_path.glob("*.npz"))) == 3


def test_pictures_that_find_no_room_are_one_line(tmp_path, breaking, capfd, monkeypatch):
    def no_room(path, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("scenarios.demonstration.pictures.write_atomic", no_room)
    assert collect(tmp_path) == 2
    first = frames_path(pictured(0, 3)[0], tmp_path)
    line = capfd.readouterr().err.splitlines()[-1]
    assert line.startswith(f"calot: --out: cannot write {first}: No space left on device; finished")


def test_without_pictures_no_perception_is_trained(tmp_path, capfd):
    words = ["train", "perception", "--data", str(tmp_path), "--out", str(tmp_path / "out")]
    assert "collect --pictures" in complaint(capfd, *words)


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="SAPIEN finds no Vulkan renderer here")
def test_pictures_of_a_patient_train_a_perception_that_sees(tmp_path):
    from controller.perception.perception import load_perception
    from scenarios.loop.camera_sense import SenseCameras
    from tissue_sim.sensing.observation import observation_of
    from tissue_sim.world import World

    called = next(d for d in pictured(0, 40) if why_call(anatomy_from_seed(d.seed)))
    frames = picture(called, tmp_path).frames
    with np.load(frames_path(called, tmp_path)) as file:
        assert file["there"].shape == (frames, N_SHOWN)
        for spec in VIEWS:
            assert file[f"rgb.{spec.name}"].shape == (frames, spec.height, spec.width, 3)
    out = tmp_path / "trained"
    words = ["train", "perception", "--preset", "smoke", "--data", str(tmp_path), "--out", str(out)]
    assert main(words) == 0
    before = load_file(out / "perception.safetensors")
    assert main(words) == 0  # nothing is left to do
    after = load_file(out / "perception.safetensors")
    assert all(after[name].equal(part) for name, part in before.items())
    tuned = [*words[:-1], str(tmp_path / "tuned"), "--base", str(out / "perception.safetensors")]
    assert main(tuned) == 0
    again = load_file(tmp_path / "tuned" / "perception.safetensors")
    kernels = {name: part for name, part in before.items() if part.ndim == 4}
    assert all((again[n] - part).norm() < 0.1 * part.norm() for n, part in kernels.items())
    world, file = World(render=True), out / "perception.safetensors"
    world.reset(anatomy_from_seed(called.seed))
    senses = [SenseCameras(3, load_perception(file)) for _ in range(2)]
    told = [sense.observe(world, world.observe()) for sense in senses]
    assert (told[0].vector() == told[1].vector()).all()  # the same seed sees the same
    assert ((told[0].std_m > 0.0) == told[0].there).all()
    assert observation_of(told[0].vector(), 0.0).n_clips == 0
