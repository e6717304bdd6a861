"""Tests of an episode that a language model plans: it continues after any answer, not without."""

import json
from itertools import groupby, islice

import numpy as np
import pytest

from planner.instruction import TASKS
from planner.llm import ATTEMPTS
from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.commands.policy_options import require_endpoint
from scenarios.files.errors import BAD_INPUT, ERROR
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tests.planner.chat_server import fails, says, sends, serving

SEED = 10_004


def steps_of(answers, monkeypatch, n):
    with serving(*answers) as server:
        monkeypatch.setenv("CALOT_LLM_URL", server.url)
        monkeypatch.setenv("CALOT_LLM_MODEL", "small")
        config = EpisodeConfig(**ORACLE | {"planner": "llm"}, scenario="textbook", seed=SEED)
        episode = begin(config)
        return list(islice(episode.steps(), n))


def test_its_tasks_are_done_as_if_the_oracle_had_given_them(monkeypatch):
    spoken = steps_of([says(TASKS[0].text)], monkeypatch, n=70)
    oracle = list(
        islice(begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED)).steps(), 70)
    )
    for mine, its in zip(spoken, oracle, strict=True):
        np.testing.assert_array_equal(mine.command.joints, its.command.joints)


def test_without_an_answer_to_follow_both_arms_hold_until_there_is_one(monkeypatch):
    good, bad = says(TASKS[0].text), ATTEMPTS * [says("cutting everything")]
    steps = steps_of([good, *bad, good], monkeypatch, n=90)
    held = [(hold, len(list(g))) for hold, g in groupby(s.instruction.hold for s in steps)]
    assert held == [(False, 30), (True, 30), (False, 30)]
    still = np.stack([step.command.joints for step in steps[30:60]])
    np.testing.assert_allclose(still - steps[29].command.joints, 0.0, atol=1e-9)
    assert steps[30].instruction.remark.startswith("small at 127.0.0.1: ")


@pytest.fixture
def endpoint(monkeypatch):
    """Return a function that names a server as the endpoint."""

    def at(server):
        monkeypatch.setenv("CALOT_LLM_URL", server.url)
        monkeypatch.setenv("CALOT_LLM_MODEL", "small")

    return at


RUN = ["run", "--planner", "llm", "--controller", "idle", "--seed", str(SEED)]


def test_an_endpoint_that_fails_later_is_an_error_in_its_words(endpoint, tmp_path, capfd):
    good, bad = says(TASKS[0].text), fails(403, "the trial of [/foo] is over")
    with serving(good, good, bad) as server:  # one is asked before the first episode
        endpoint(server)
        code = main([*RUN, "--scenario", "textbook", "--out", str(tmp_path)])
    why = "small at 127.0.0.1: it answered 403 Forbidden: the trial of [/foo] is over"
    assert code == ERROR
    (episode,) = json.loads((tmp_path / "results.json").read_text())["episodes"]
    assert episode["error"] == f"EndpointError: {why}"
    assert f"seed {SEED} ended in error: EndpointError: {why}" in capfd.readouterr().out


DOWN = {
    "in error": (fails(401, "wrong key"), "it answered 401 Unauthorized: wrong key"),
    "no endpoint": (sends(b"<html>", kind="text/html"), "it answered text/html"),
}


@pytest.mark.parametrize(("answer", "why"), DOWN.values(), ids=DOWN)
@pytest.mark.parametrize("command", [RUN, ["evaluate", "--arms", "talker=llm+idle"]])
def test_an_endpoint_is_asked_before_the_first_episode(
    endpoint, tmp_path, capsys, command, answer, why
):
    with serving(answer) as server:
        endpoint(server)
        assert main([*command, "--out", str(tmp_path / "out")]) == BAD_INPUT
    (line,) = capsys.readouterr().err.splitlines()
    assert f"small at 127.0.0.1: {why}" in line
    assert not (tmp_path / "out").exists()


def test_one_that_is_down_is_told_before_the_first_episode(endpoint, tmp_path, capsys):
    with serving(says(TASKS[0].text)) as server:
        endpoint(server)
    assert main([*RUN, "--out", str(tmp_path)]) == BAD_INPUT
    (line,) = capsys.readouterr().err.splitlines()
    assert "small at 127.0.0.1: it cannot be reached: " in line


def test_a_model_that_answers_nonsense_may_try(endpoint):
    with serving(says("cutting everything")) as server:
        endpoint(server)
        require_endpoint()
    assert len(server.asked) == 1
