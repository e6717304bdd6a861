"""Tests that nobody who acts reads the state of the tissue but through the sense."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
import torch

from controller.base import Controller
from controller.diffusion.config import PolicyConfig
from controller.diffusion.controller import ControllerDiffusion
from controller.diffusion.graph import Sampler
from controller.diffusion.policy import Policy
from controller.perception.checkpoint import PerceptionConfig, PerceptionModel
from controller.perception.graph import ViewReader
from controller.perception.network import NetworkConfig
from controller.perception.perception import Perception
from controller.perception.prior import Prior
from planner.learned.network import PlannerConfig, PlannerNetwork
from planner.learned.planner import PlannerLearned
from scenarios.episode import Episode
from scenarios.loop.camera_sense import SenseCameras
from scenarios.loop.episode_config import EpisodeConfig
from tests.tissue_sim.outcome.clipping import cut, three_clips
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.rendering.renderer import renderer_available
from tissue_sim.sensing.eyes import VIEWS
from tissue_sim.sensing.observation import N_LINE, Observation
from tissue_sim.sensing.sense import Sense
from tissue_sim.sensing.tracked import SenseTracked
from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.cut import Cut
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

SEED, STEPS = 5, 90
SMALL = PolicyConfig(condition_width=16, condition_blocks=1, denoiser_width=16, denoiser_blocks=1)


def treated() -> tuple[tuple[Clip, ...], tuple[Cut, ...]]:
    """Return the clips and cuts of a treatment that never took place in the episodes."""
    world = World()
    world.reset(textbook_from_seed(SEED))
    three_clips(world, "duct")
    cut(world, "duct", 0.6 * world.tubes.length_m["duct"])
    return world.record.clips, world.record.cuts


class ScrambledWorld(World):
    """A world whose tissue, clips, cuts and forces are wrong while the robot thinks."""

    def __init__(self, **options: bool) -> None:
        super().__init__(**options)
        self._clips, self._cuts = treated()

    def scramble(self) -> None:
        self._true = self.state()
        rng = np.random.default_rng(7)
        x = self.tissue.positions()
        x += rng.normal(scale=0.01, size=x.shape).astype(np.float32)
        self.wrenches = (self.wrenches[0] + 1.0, self.wrenches[1] - 1.0)
        grasp = replace(self.record.grasp, pinch_n=9.0, vertices=(1, 2, 3))
        loaded = not self.record.clip_loaded
        self.record = replace(
            self.record,
            grasp=grasp,
            clip_loaded=loaded,
            jaws_opened=True,
            clips=self._clips,
            cuts=self._cuts,
        )

    def step(self, command: JointCommand, *, intended: str | None = None) -> Observation:
        self.restore(self._true)
        return super().step(command, intended=intended)

    def equip(self, instrument: str) -> None:
        """Exchange the tool of the true world: the nurse works on it while the robot thinks."""
        self.restore(self._true)
        super().equip(instrument)
        self.scramble()


class SenseThenScramble:
    """Senses the true state by another sense, and scrambles it afterwards."""

    def __init__(self, sense: Sense) -> None:
        self._sense = sense

    def observe(self, world: ScrambledWorld, exact: Observation) -> Observation:
        seen = self._sense.observe(world, exact)
        world.scramble()
        return seen


@pytest.fixture(scope="module")
def sampler() -> Sampler:
    """Return a small untrained policy that moves the arms some tenths of a millimetre a step."""
    torch.manual_seed(3)
    policy = Policy(SMALL)
    policy.chunk_deviation *= 3e-4
    return Sampler(policy.eval().requires_grad_(False))


def planner() -> PlannerLearned:
    torch.manual_seed(4)
    network = PlannerNetwork(PlannerConfig(width=32, layers=1)).eval().requires_grad_(False)
    return PlannerLearned(network)


def perception() -> Perception:
    """Return an untrained perception whose prior is the patient, so that it sees something."""
    torch.manual_seed(5)
    world = World()
    mean = world.reset(textbook_from_seed(SEED)).points_m()[:N_LINE].ravel()
    config = PerceptionConfig(
        views=tuple(spec.name for spec in VIEWS),
        sizes=tuple((spec.width, spec.height) for spec in VIEWS),
        network=NetworkConfig(widths=(8, 8, 8, 8, 8), maps=8),
    )
    prior = Prior(
        mean=mean,
        spread=0.0005**2 * np.eye(len(mean)),
        drift=0.002**2 * np.eye(len(mean)),
        radius_m=np.full(3, 0.002),
        sac_radius_m=np.full(5, 0.01),
    )
    model = PerceptionModel(config, prior).eval()
    return Perception(ViewReader(model), model.prior())


def commands(world: World, sense: Sense, controller: Controller) -> np.ndarray:
    exact = world.reset(textbook_from_seed(SEED))
    episode = Episode(
        config=EpisodeConfig(scenario="textbook", seed=SEED, sense="tracked"),
        world=world,
        planner=planner(),
        controller=controller,
        sense=sense,
        observation=sense.observe(world, exact),
    )
    return np.stack([step.command.joints for step in islice(episode.steps(), STEPS)])


def test_a_wrong_state_behind_the_sense_changes_no_command(sampler: Sampler):
    """Compare planner, controller, driver, filter and nurse together, to the bit."""
    one, other = (ControllerDiffusion(SMALL, sampler) for _ in range(2))
    plain = commands(World(), SenseTracked(SEED), one)
    behind = commands(ScrambledWorld(), SenseThenScramble(SenseTracked(SEED)), other)
    np.testing.assert_array_equal(behind, plain)
    assert np.ptp(plain, axis=0).max() > 1e-3


@pytest.mark.render
@pytest.mark.skipif(not renderer_available(), reason="there is no Vulkan renderer")
def test_a_wrong_state_behind_the_pictures_changes_no_command(sampler: Sampler):
    """Compare the same with perception from rendered pictures in front."""
    one, other = (ControllerDiffusion(SMALL, sampler) for _ in range(2))
    plain = commands(World(render=True), SenseCameras(SEED, perception()), one)
    scrambled = SenseThenScramble(SenseCameras(SEED, perception()))
    behind = commands(ScrambledWorld(render=True), scrambled, other)
    np.testing.assert_array_equal(behind, plain)
    assert np.ptp(plain, axis=0).max() > 1e-3
