"""Tests of each kind of perturbation, measured on the world."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from planner.instruction import TASKS
from scenarios.catalogue import CONTROLLERS, PolicyEntry
from scenarios.perturbation.body import (
    BREATH_S,
    NUDGE_S,
    LargeGallbladder,
    ShortTubes,
    SoftTissue,
    StiffTissue,
    WideTubes,
)
from scenarios.perturbation.effects import Effects
from scenarios.perturbation.perturbation import AtTask, AtTime
from scenarios.perturbation.perturbations import MANUAL
from scenarios.perturbation.slips import GRASP_SLIPS_S
from tests.scenarios.perturbation.episodes import SEED, disturbed, perturbation
from tests.worlds import textbook_world
from tissue_sim.frames import UP, inverse_pose, rotation_vector
from tissue_sim.outcome.predicates import gallbladder_held
from tissue_sim.patient.anatomy import RANGES, WIDEST_TUBE, anatomy_from_seed
from tissue_sim.patient.population import LAWS
from tissue_sim.patient.textbook import TEXTBOOK, textbook_from_seed
from tissue_sim.world import World

WAVES = "tests.scenarios.perturbation.waving_controller:ControllerWaves"
FLOAT32_M = 2e-8


def test_breathing_moves_the_fixed_ends_as_a_sine(monkeypatch):
    start_s, amplitude_m = 0.5, 0.003
    breathing = perturbation("breathing", magnitude=amplitude_m, at=AtTime(time_s=start_s))
    episode = disturbed(monkeypatch, breathing, controller="idle")
    fixed = episode.world.organ.fixed
    at_rest = episode.world.organ.vertices[fixed]
    for step in islice(episode.steps(), 60):
        phase = 2 * np.pi * max(step.time_s - start_s, 0.0) / BREATH_S
        moved = episode.world.tissue.positions()[fixed] - at_rest
        expected = np.tile(amplitude_m * np.sin(phase) * UP, (len(moved), 1))
        np.testing.assert_allclose(moved, expected, atol=FLOAT32_M)


def passing(world: World, seconds: float) -> Iterator[None]:
    """Yield once a control step while the clock runs and nothing else happens."""
    for _ in range(round(seconds / world.config.control_step_s)):
        yield
        time_s = world.record.time_s + world.config.control_step_s
        world.record = replace(world.record, time_s=time_s)


def offsets_m(*perturbations):
    """Return where these perturbations alone want the body in each step of four seconds."""
    world, effects = textbook_world(SEED), Effects(perturbations, SEED)
    wanted = []
    for _ in passing(world, 4.0):
        effects.before_step(world, TASKS[0])
        wanted.append(world.body.target_m.copy())
    return np.array(wanted)


def test_two_that_move_the_body_add_up():
    """A nudge while the patient breathes: neither hides the other, and breathing goes on after."""
    breathing, nudge = perturbation("breathing", at=AtTime(time_s=0.5)), MANUAL["nudge the tissue"]
    alone, pushed = offsets_m(breathing), offsets_m(nudge)
    for both in (offsets_m(breathing, nudge), offsets_m(nudge, breathing)):
        np.testing.assert_allclose(both, alone + pushed, atol=1e-15)
    n = round((NUDGE_S + 0.1) * 30)
    assert np.abs(pushed[:n]).max() == pytest.approx(nudge.magnitude, rel=0.01)
    assert np.abs(pushed[n:]).max() < 1e-12
    assert np.ptp(alone[n:], axis=0).max() > 0.5 * breathing.magnitude


@pytest.mark.parametrize("delay", [1, 7])
def test_latency_delays_each_command_by_exactly_as_many_steps(monkeypatch, delay):
    monkeypatch.setitem(CONTROLLERS, "waves", PolicyEntry(factory=WAVES))
    late = perturbation("latency", magnitude=delay)
    episodes = [
        disturbed(monkeypatch, controller="waves"),
        disturbed(monkeypatch, late, controller="waves"),
    ]
    start = episodes[1].world.target
    commands = [
        np.stack([step.command.joints for step in islice(episode.steps(), 40)])
        for episode in episodes
    ]
    np.testing.assert_array_equal(commands[1][delay:], commands[0][:-delay])
    np.testing.assert_allclose(commands[1][:delay], np.tile(start, (delay, 1, 1)), atol=1e-12)
    assert np.ptp(commands[1][delay:], axis=0).max() > 1e-3


@pytest.mark.parametrize("name", ["camera-shift", "camera-turn"])
def test_the_endoscope_is_moved_by_the_magnitude_at_its_moment_and_no_more(monkeypatch, name):
    bump = perturbation(name, magnitude=0.02, at=AtTime(time_s=0.5))
    episode = disturbed(monkeypatch, bump, controller="idle")
    before = episode.world.T_world_endoscope
    for step in islice(episode.steps(), 30):
        change = inverse_pose(before) @ episode.world.T_world_endoscope
        sizes = np.linalg.norm(change[:3, 3]), np.linalg.norm(rotation_vector(change[:3, :3]))
        bumped = 0.02 if step.time_s > 0.5 + 0.01 else 0.0
        expected = (bumped, 0.0) if name == "camera-shift" else (0.0, bumped)
        np.testing.assert_allclose(sizes, expected, atol=1e-9)


def test_motions_are_in_the_current_frame_of_the_endoscope(monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "waves", PolicyEntry(factory=WAVES))
    bump = perturbation("camera-turn", magnitude=0.5, at=AtTime(time_s=0.0))
    episode = disturbed(monkeypatch, bump, controller="waves")
    tips = [s.observation.tips_endoscope[:, :3, 3] for s in islice(episode.steps(), 12)]
    moved = tips[-1] - tips[2]  # the controller moves along (1, 1, 1) in the endoscope's frame
    along = moved / np.linalg.norm(moved, axis=1, keepdims=True)
    np.testing.assert_allclose(along, np.full((2, 3), 3**-0.5), atol=0.02)


OUT_OF_RANGE = pytest.mark.parametrize(
    ("effect", "name"),
    [
        (StiffTissue, "stiff-tissue"),
        (SoftTissue, "soft-tissue"),
        (WideTubes, "wide-tubes"),
        (ShortTubes, "short-tubes"),
        (LargeGallbladder, "large-gallbladder"),
    ],
)


@OUT_OF_RANGE
def test_a_patient_goes_steadily_to_the_limit_of_what_is_possible(effect, name):
    anatomy, rng = anatomy_from_seed(10_001), np.random.default_rng(0)
    moved = [
        effect(perturbation(name, magnitude=m), rng).on_anatomy(anatomy)
        for m in (0.0, 0.25, 0.5, 0.75, 1.0)
    ]
    assert moved[0] == anatomy
    for parameter in effect.parameters:
        values = [getattr(a, parameter) for a in moved]
        assert values[-1] == pytest.approx(getattr(RANGES[parameter], effect.limit))
        steps = np.diff(np.log(values))
        np.testing.assert_allclose(steps, steps[0])


@OUT_OF_RANGE
def test_the_limit_is_possible_for_every_seed(effect, name):
    rng = np.random.default_rng(0)
    for seed in range(10_000, 10_100):
        for magnitude in (0.5, 1.0):
            effect(perturbation(name, magnitude=magnitude), rng).on_anatomy(anatomy_from_seed(seed))


def test_no_tube_becomes_wider_than_what_it_enters():
    widest, rng = perturbation("wide-tubes", magnitude=1.0), np.random.default_rng(0)
    anatomies = (anatomy_from_seed(seed) for seed in range(10_000, 10_100))
    narrow = [a for a in anatomies if a.gallbladder_width_m < 0.030]
    for anatomy in narrow:
        moved = WideTubes(widest, rng).on_anatomy(anatomy)
        assert moved.duct_diameter_m == pytest.approx(WIDEST_TUBE * anatomy.gallbladder_width_m)
    assert narrow


def test_each_of_several_slips_lasts_as_long_in_whatever_order_they_come():
    """The task of the second slip comes first, as where the tubes are treated in another order."""
    world = textbook_world(SEED)
    effects = Effects([perturbation("grasp-slip", at=AtTask(index=k)) for k in (4, 6)], SEED)
    slipped_s = {}
    for k in (5, 6, 5, 4, 5):
        for _ in passing(world, GRASP_SLIPS_S + 1.0):
            effects.before_step(world, TASKS[k - 1])
            slips = world.conditions.grip == 0.0
            slipped_s[k] = slipped_s.get(k, 0.0) + slips * world.config.control_step_s
    full = pytest.approx(GRASP_SLIPS_S, abs=1.1 * world.config.control_step_s)
    assert slipped_s == {4: full, 5: 0.0, 6: full}


def test_by_default_no_patient_is_in_the_range_that_the_description_names():
    drawn = LAWS["stiffness_scale"]
    for seed in range(10_000, 10_200):
        anatomy, rng = textbook_from_seed(seed), np.random.default_rng(0)
        wide = WideTubes(perturbation("wide-tubes"), rng).on_anatomy(anatomy)
        assert wide.duct_diameter_m > TEXTBOOK["duct_diameter_m"][1]
        assert wide.artery_diameter_m > TEXTBOOK["artery_diameter_m"][1]
        stiff = StiffTissue(perturbation("stiff-tissue"), rng).on_anatomy(anatomy)
        soft = SoftTissue(perturbation("soft-tissue"), rng).on_anatomy(anatomy)
        assert soft.stiffness_scale < drawn.low < drawn.high < stiff.stiffness_scale


def test_a_slip_loses_the_gallbladder_and_it_is_grabbed_again(monkeypatch):
    episode = disturbed(monkeypatch, perturbation("grasp-slip", at=AtTask(index=2)))
    steps, world = episode.steps(), episode.world
    assert any(step.applied for step in steps)
    assert any(not gallbladder_held(world) for _ in islice(steps, 60))
    again = (s for s in islice(steps, 450) if s.instruction.task == TASKS[0])
    assert any(step.outcome.task_done for step in again)
    assert world.record.grasp.vertices
    assert world.conditions.grip == 1.0


def test_the_applier_loses_as_many_clips_as_said_and_the_nurse_brings_others(monkeypatch):
    lost = perturbation("clip-dropped", magnitude=2, at=AtTask(index=2))
    episode = disturbed(monkeypatch, lost)
    dropped = exchanges = 0
    for step in episode.steps():
        dropped += len(step.applied)
        assert not (step.applied and step.observation.clip_loaded)
        exchanges += step.exchange
        if step.instruction.task.index == 2 and step.outcome.task_done:
            break
    assert dropped == 2
    assert exchanges
    assert [c.dropped for c in episode.world.record.clips] == [True, True, False]
