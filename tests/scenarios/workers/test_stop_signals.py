"""Tests of when a signal stops a program: at once, or after what is saved, counted or imported."""

import os
import signal
from contextlib import suppress

import pytest

from scenarios.workers.process import (
    STOP_SIGNALS,
    counting,
    importing,
    saving,
    stop_code,
    stoppable,
)


@pytest.fixture(autouse=True)
def _handlers():
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    for number in STOP_SIGNALS:  # another test may have left them ignored, as a command that ends
        signal.signal(number, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def stop(number=signal.SIGTERM):
    os.kill(os.getpid(), number)


def caught(program):
    """Return what a stoppable program has done when KeyboardInterrupt ends it."""
    done = []
    with stoppable(), pytest.raises(KeyboardInterrupt):
        program(done)
    return done


@pytest.mark.parametrize("number", STOP_SIGNALS)
def test_a_signal_raises_at_once_and_gives_its_code(number):
    def program(done):
        stop(number)
        done.append("went on")

    assert caught(program) == []
    assert stop_code() == 128 + number


@pytest.mark.parametrize("block", [saving, importing])
def test_a_signal_waits_for_the_end_of_a_block(block):
    def program(done):
        with block():
            stop()
            done.append("whole")
        done.append("went on")

    assert caught(program) == ["whole"]


def test_a_signal_waits_from_the_first_save_to_the_count():
    def program(done):
        with counting():
            with saving():
                stop()
                done.append("saved")
            done.append("counted")
        done.append("went on")

    assert caught(program) == ["saved", "counted"]


def test_a_signal_before_the_first_save_is_raised_at_once_also_after_an_import():
    def program(done):
        with counting():
            with importing():
                done.append("imported")
            stop()
            done.append("went on")

    assert caught(program) == ["imported"]


def test_what_is_saved_after_a_signal_is_not_cut_short_by_the_next():
    done = []
    with stoppable():
        with suppress(KeyboardInterrupt):
            stop()
        with saving():
            stop()
            done.append("saved")
        stop(signal.SIGINT)
        done.append("reported")
    assert done == ["saved", "reported"]
    assert stop_code() == 128 + signal.SIGTERM


def test_a_signal_that_a_library_swallowed_can_be_sent_again():
    with stoppable():
        with suppress(KeyboardInterrupt):
            stop()
        with pytest.raises(KeyboardInterrupt):
            stop()


def test_a_signal_that_was_ignored_at_the_start_is_ignored_and_handlers_come_back():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    before = signal.getsignal(signal.SIGTERM)
    with stoppable():
        stop(signal.SIGHUP)
    assert signal.getsignal(signal.SIGTERM) is before
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


def test_an_error_while_saving_is_raised_and_the_signal_with_the_next_save():
    def save(error):
        with saving():
            stop()
            raise error

    with stoppable():
        with pytest.raises(OSError, match="no room"):
            save(OSError("no room"))
        with pytest.raises(KeyboardInterrupt), saving():
            pass


@pytest.mark.parametrize("number", STOP_SIGNALS)
def test_a_signal_after_the_work_does_not_take_the_exit_code_away(number):
    with stoppable(ends_program=True):
        done = "whole"
    stop(number)
    assert done == "whole"
