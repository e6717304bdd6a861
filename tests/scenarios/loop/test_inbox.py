"""Tests of the inbox: no text is lost or doubled, and each thread's texts stay in order."""

from collections import Counter
from threading import Thread

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.command import COMMANDS
from scenarios.loop.person.inbox import LONGEST, Inbox
from scenarios.loop.person.script import Timed

THREADS, EACH = 16, 200
BELL = "\a"  # a text with a control character is read quickly


def test_many_threads_lose_nothing_and_keep_their_order():
    inbox, taken = Inbox(), []

    def speak(who):
        for n in range(EACH):
            inbox.say(f"{who} {n} {BELL}")

    threads = [Thread(target=speak, args=(who,)) for who in range(THREADS)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        taken += inbox.take(0.0)
    taken += inbox.take(0.0)
    texts = [reading.text.removesuffix(f" {BELL}") for reading in taken]
    assert Counter(texts) == Counter(f"{w} {n}" for w in range(THREADS) for n in range(EACH))
    for who in range(THREADS):
        mine = [text for text in texts if text.split()[0] == str(who)]
        assert mine == [f"{who} {n}" for n in range(EACH)]


@given(st.lists(st.floats(0.0, 10.0), max_size=20), st.lists(st.floats(0.0, 1.0), max_size=30))
def test_words_come_at_their_time_once_and_in_order(times_s, waits_s):
    inbox, now_s, came = Inbox(), 0.0, []
    inbox.arrange([Timed(time_s=t, text=f"{t}{BELL}") for t in times_s])
    for wait_s in waits_s:
        now_s += wait_s
        for reading in inbox.take(now_s):
            due_s = float(reading.text.removesuffix(BELL))
            assert now_s - wait_s - 1e-9 <= due_s <= now_s + 1e-9
            came.append(due_s)
    assert came == [t for t in sorted(times_s) if waits_s and t <= now_s + 1e-9]


def test_a_new_arrangement_replaces_the_old_one():
    inbox = Inbox()
    inbox.arrange([Timed(time_s=1.0, text="stop")])
    inbox.arrange([Timed(time_s=2.0, text="resume")])
    assert [reading.text for reading in inbox.take(3.0)] == ["resume"]


def test_a_button_is_its_command():
    inbox = Inbox()
    for command in COMMANDS.values():
        inbox.press(command)
    readings = inbox.take(0.0)
    assert [reading.command for reading in readings] == list(COMMANDS.values())
    assert not any(reading.guesses for reading in readings)  # "yes" would do it again


@pytest.mark.parametrize("text", ["clip the duct " * 20_000, "a" * LONGEST + " stop"])
def test_a_text_that_is_too_long_to_be_read_is_kept_short_and_holds_the_arms(text):
    reading = Inbox().say(text)
    assert reading.text == text[:LONGEST]
    assert reading.command == COMMANDS["stop"]
    assert not reading.guesses


def test_half_a_letter_is_no_longer_in_a_text_that_was_heard():
    assert Inbox().say(f"\ud800 {BELL}").text.encode() == f"? {BELL}".encode()
