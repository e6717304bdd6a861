"""The start of an episode in which people speak, press buttons, disturb and guide an arm."""

import numpy as np

from planner.command import COMMANDS
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Inbox
from scenarios.perturbation.perturbations import MANUAL
from scenarios.recording.recorder import Recorder, load
from scenarios.run_episode import begin
from tissue_sim.tools.arms import LEFT_ARM

STEPS = 900


def record(path, config):
    """Return the recording of an episode's start and the world at its end.

    The nurse brings a tool, its clip is dropped, the nurse loads another one, and that is dropped,
    too; soon afterwards the episode stops.
    """
    inbox = Inbox()
    episode = begin(config, inbox=inbox)
    exchanged, exchanges, stop = False, 0, STEPS
    with Recorder(config=config, path=path) as recorder:
        recorder.on_reset(episode.world)
        for k, step in enumerate(episode.steps()):
            recorder.on_step(step)
            _interfere(k, inbox, episode.world)
            if exchanged and not step.exchange:
                inbox.disturb(MANUAL["drop the clip"])
                exchanges += 1
                stop = k + 20 if exchanges == 2 else stop
            exchanged = step.exchange
            if k == stop:
                break
    return load(path), episode.world


def _interfere(k, inbox, world):
    if k == 50:
        inbox.press(COMMANDS["move right arm higher"])
    if k == 70:
        inbox.say("the weather is nice")
        inbox.say("please lower the right arm a little")
    if k == 90:
        inbox.disturb(MANUAL["shift the camera"])
    if k == 100:
        inbox.disturb(MANUAL["nudge the tissue"])
    if k == 110:
        inbox.press(COMMANDS["pause"])
    if k == 120:
        inbox.press(COMMANDS["resume"])
    if 130 <= k < 140:
        goal = world.arms.T_world_tool()[LEFT_ARM]
        goal[:3, 3] += world.T_world_endoscope[:3, :3] @ np.array([0.0, 2e-3, 0.0])
        inbox.guided = GuidedArm(arm=LEFT_ARM, T_world_goal=goal, jaw_rad=0.3)
    if k == 140:
        inbox.guided = None
