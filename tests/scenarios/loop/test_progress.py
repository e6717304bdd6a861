"""Tests of the terminal's display: what people said, and what came of it, stands there."""

from io import StringIO
from itertools import islice

from rich.console import Console

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import ProgressDisplay
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.person.script import Timed
from scenarios.run_episode import begin

HIGHER = "move right arm higher"


def test_a_reply_and_later_what_came_of_the_order_are_shown_with_their_times():
    inbox = Inbox()
    inbox.arrange([Timed(time_s=0.5, text=HIGHER)])
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=10_004), inbox=inbox)
    shown = StringIO()
    with ProgressDisplay(1, Console(file=shown, width=200)) as display:
        display.on_reset(episode.world)
        steps = list(islice(episode.steps(), 200))
        for step in steps:
            display.on_step(step)
    (heard,) = [heard for step in steps for heard in step.heard]
    told_s, told = next((step.time_s, told) for step in steps for told in step.told)
    said = [line for line in shown.getvalue().splitlines() if line]
    assert said[:2] == [f"0.5 s, {HIGHER!r}: {heard.reply}", f"{told_s:.1f} s: {told}"]
