"""Tests of what `calot` says of episodes that broke off, or ended before all was said."""

from planner.instruction import TASKS
from scenarios.cli import main
from scenarios.commands.run import unsaid_lines
from scenarios.files.errors import ERROR
from scenarios.loop.person.script import Timed, read_script
from tests.scenarios.example_results import ERROR as ERROR_RESULT
from tests.scenarios.example_results import PASSED
from tests.scenarios.from_the_shell.complaint import complaint

SEED = 10_004
SAYS_TEXT = f"{__name__}:SaysText"


class SaysText:
    """Answers with words, where an instruction is expected."""

    def __init__(self, setup):
        pass

    def reset(self):
        pass

    def plan(self, observation):
        return TASKS[0].text


def run(out, *words):
    return main(["run", "--scenario", "textbook", "--seed", str(SEED), "--out", str(out), *words])


def test_the_traceback_is_named_and_lies_there(tmp_path, capfd):
    assert run(tmp_path, "--planner", SAYS_TEXT) == ERROR
    out, _ = capfd.readouterr()
    trace = tmp_path / "errors" / f"{SEED}.txt"
    assert "ended in error: TypeError: planner: plan returned a str, not an Instruction" in out
    assert f"traceback: {trace}" in out
    assert "plan returned a str" in trace.read_text()


def test_what_broke_off_before_its_first_step_is_not_replayed_as_identical(tmp_path, capfd):
    run(tmp_path, "--planner", SAYS_TEXT)
    file = str(tmp_path / "episodes" / f"{SEED}.npz")
    _ = capfd.readouterr()
    assert "it broke off before its first step: TypeError" in complaint(capfd, "replay", file)
    assert main(["replay", "--verify", "--planner", SAYS_TEXT, file]) == 0
    assert "identical, 0 steps; it broke off: TypeError" in capfd.readouterr().out


def test_what_was_not_said_as_the_episode_had_ended_is_told():
    end_s = PASSED.procedure_time_s + PASSED.exchange_time_s
    script = [Timed(time_s=s, text="stop") for s in (0.5 * end_s, end_s + 1.0, end_s + 2.0)]
    (line,) = unsaid_lines([PASSED, ERROR_RESULT], script)
    told = f"seed {PASSED.seed} ended at {end_s:.1f} s: 2 of 3 lines of --instruct were not said"
    assert line == told
    assert not list(unsaid_lines([PASSED], script[:1]))


def test_a_script_may_begin_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "said.tsv"
    path.write_text("\ufeff12\tstop\n", encoding="utf-8")
    assert read_script(path) == (Timed(time_s=12.0, text="stop"),)
