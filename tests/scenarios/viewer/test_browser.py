"""Tests of the page in a real browser: what a person sees and does; screenshots in tmp_path."""

import io
import math

import numpy as np
import pytest

from controller.dataset.part import read_part
from scenarios.recording.recorder import load
from scenarios.viewer.serving.page_process import PageProcess
from scenarios.viewer.serving.port import choose_port
from tests.scenarios.viewer.chromium import (
    browser,
    button,
    enter,
    missing,
    open_tab,
    press,
    type_in,
)
from tests.scenarios.viewer.sessions import SEED, run_to, running_session, wait_until
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.tools.arms import RIGHT_ARM

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(missing()), reason=missing() or "there is one"),
]

HOST = "127.0.0.1"


@pytest.fixture(scope="module")
def chromium():
    with browser() as chromium:
        yield chromium


@pytest.fixture
def session(tmp_path):
    with running_session(tmp_path) as session:
        yield session


@pytest.fixture
def tab(chromium, session):
    with (
        PageProcess(session, host=HOST, port=choose_port(HOST)) as page,
        open_tab(chromium, f"http://{HOST}:{page.port}") as tab,
    ):
        tab.get_by_text("Ready: press Start").wait_for()
        yield tab


def say(tab, text):
    type_in(tab, text)
    enter(tab)


def picture(tab, path):
    """Return a (height, width, 3) screenshot."""
    from PIL import Image

    content = tab.screenshot(path=path)
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)


def share_of_green(picture):
    """Return the green share of the screen; only the gallbladder is large and green."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return ((green > red + 5) & (green > blue + 15) & (green > 60)).mean()


def recorded(session):
    """Return the recording, which is closed by a person's reset."""
    path = session.out / "episodes" / f"{SEED}.npz"
    wait_until(path.exists)
    return load(path)


def tip_moved_m(recording, heard, after_s):
    """Return the (3,) motion of the right tip after an instruction, in the endoscope frame."""
    tips = recording.arrays["tips_endoscope"][:, RIGHT_ARM, :3, 3]
    last = min(heard["step"] + round(after_s / CONTROL_PERIOD_S), len(tips) - 1)
    return tips[last] - tips[heard["step"]]


def test_the_page_loads_and_the_tissue_is_drawn(tab, tmp_path):
    wait_until(lambda: share_of_green(picture(tab, tmp_path / "loaded.png")) > 0.01)


def test_a_button_moves_the_right_tip_up(tab, session):
    press(tab, "Start")
    run_to(session, 0.5)
    press(tab, "move right arm higher")
    wait_until(lambda: session.watcher.status().instruction.source == "human")
    run_to(session, session.watcher.status().time_s + 2.2)
    session.pace.restart(session.config)
    (heard,) = recorded(session).heard
    assert tip_moved_m(recorded(session), heard, 2.0)[1] >= 0.003


def test_a_sentence_is_obeyed_and_its_reading_is_shown(tab, session):
    press(tab, "Start")
    run_to(session, 0.5)
    say(tab, "to the left by ten millimetres with the clip applier")
    wait_until(lambda: session.watcher.status().instruction.source == "human")
    session.pace.pause()  # else the end of the order is told before a slow page is drawn
    tab.locator(".reply", has_text="move right arm to the left").wait_for()
    session.pace.go_on()
    run_to(session, session.watcher.status().time_s + 2.2)
    session.pace.restart(session.config)
    (heard,) = recorded(session).heard
    x, y, z = tip_moved_m(recorded(session), heard, 1.0)
    assert 0.006 <= x <= 0.0105
    assert max(abs(y), abs(z)) < 0.1 * x


def test_nonsense_is_asked_back_and_changes_nothing(tab, session):
    press(tab, "Start")
    run_to(session, 0.3)
    say(tab, "the weather is nice today")
    tab.locator(".reply", has_text="weather").wait_for()
    run_to(session, session.watcher.status().time_s + 0.3)
    status = session.watcher.status()
    assert [line.kind for line in status.lines if "weather" in line.text] == ["asked back"]
    assert status.instruction.source == "planner"


def test_an_unclear_sentence_is_asked_back_with_guesses_as_buttons(tab, session):
    press(tab, "Start")
    run_to(session, 0.3)
    say(tab, "up a bit")
    guess = button(tab, "move left arm higher by 1.5 mm")
    wait_until(lambda: guess.count() == 1)
    assert session.watcher.status().instruction.source == "planner"
    guess.dispatch_event("click")
    wait_until(lambda: session.watcher.status().instruction.source == "human")
    assert session.watcher.status().instruction.text == "move left arm higher"
    assert session.watcher.status().instruction.left_m <= 0.0015


def test_pause_step_and_go_on_do_what_they_say(tab, session):
    press(tab, "Start")
    run_to(session, 0.5)
    press(tab, "Pause")
    wait_until(lambda: session.pace.paused)
    tab.wait_for_timeout(300)
    held_s = session.watcher.status().time_s
    tab.wait_for_timeout(1000)
    assert session.watcher.status().time_s == held_s
    press(tab, "Step")
    run_to(session, held_s + 0.5 * CONTROL_PERIOD_S)
    tab.wait_for_timeout(300)
    assert session.watcher.status().time_s == pytest.approx(held_s + CONTROL_PERIOD_S)
    press(tab, "Go on")
    run_to(session, held_s + 1.0)


def test_reset_begins_an_episode_with_the_chosen_seed(tab, session):
    press(tab, "Start")
    run_to(session, 0.5)
    tab.get_by_text("New patient").click()
    seed = tab.get_by_text("seed", exact=True).locator("xpath=../../..").locator("input")
    seed.fill(str(SEED + 7))
    tab.wait_for_timeout(300)
    before = session.watcher.patient
    press(tab, "Reset")
    wait_until(lambda: session.watcher.patient is not before)
    assert session.watcher.patient.anatomy.seed == SEED + 7


def test_a_reload_and_a_second_tab_keep_the_episode(chromium, tab, session, tmp_path):
    press(tab, "Start")
    run_to(session, 0.5)
    patient = session.watcher.patient
    tab.reload()
    with open_tab(chromium, tab.url) as other:
        for each in (tab, other):
            each.get_by_text("grabbing gallbladder").first.wait_for()
        run_to(session, session.watcher.status().time_s + 0.5)
        assert session.watcher.patient is patient
        wait_until(lambda: share_of_green(picture(other, tmp_path / "second.png")) > 0.01)
        press(other, "Pause")
        wait_until(lambda: session.pace.paused)
        button(tab, "Go on").wait_for()


def test_saving_an_intervention_makes_a_loadable_episode(tab, session):
    press(tab, "Start")
    run_to(session, 0.3)
    press(tab, "move left arm lower")
    save = "Save this intervention as training data"
    tab.locator(f'button:enabled:has-text("{save}")').wait_for()
    run_to(session, session.watcher.status().time_s + 0.5)
    press(tab, save)
    wait_until(lambda: list(session.out.glob("interventions/parts/*.parquet")))
    (path,) = session.out.glob("interventions/parts/*.parquet")
    assert "move left arm lower" in read_part(path).columns["correction"]


def test_keys_do_what_the_legend_says(tab, session):
    tab.keyboard.press("Space")
    wait_until(lambda: not session.pace.paused)
    run_to(session, 0.1)
    tab.keyboard.press("Shift+KeyI")
    wait_until(lambda: session.watcher.status().instruction.text == "move left arm higher")
    tab.keyboard.press("KeyH")
    wait_until(lambda: session.watcher.status().instruction.hold)


def test_a_person_guides_an_arm_until_giving_it_back(tab, session):
    press(tab, "Start")
    tab.get_by_text("Take over an arm").click()
    press(tab, "Take the right")
    wait_until(lambda: session.watcher.status().guided_arm == RIGHT_ARM)
    press(tab, "Give it back")
    wait_until(lambda: session.watcher.status().guided_arm is None)


def test_an_exported_page_works_offline(chromium, tmp_path, session):
    from scenarios.viewer.recording_frames import RecordingFrames
    from scenarios.viewer.replay_page import export

    session.pace.speed = math.inf
    session.pace.go_on()
    run_to(session, 24.0)  # the page loops, and fades in each time
    session.pace.restart(session.config)
    page = tmp_path / "page.html"
    page.write_text(export(RecordingFrames(recorded(session), every=6), lambda time_s: None))
    with open_tab(chromium, page.as_uri(), offline=True) as tab:
        wait_until(lambda: share_of_green(picture(tab, tmp_path / "exported.png")) > 0.01)


RECOGNISER = """window.SpeechRecognition = class {
  start() { setTimeout(() => this.onresult({results: [[{transcript: "wait"}]]}), 0); }
  stop() {
    this.onresult({results: [[{transcript: "wait, don't"}], [{transcript: "cut the duct"}]]});
    this.onend();
  }
};"""


def test_what_is_said_while_the_button_is_held_is_heard_by_the_episode(chromium, session):
    say_port = choose_port(HOST) + 1
    with (
        PageProcess(session, host=HOST, port=choose_port(HOST), say_port=say_port),
        open_tab(chromium, f"http://{HOST}:{say_port}", script=RECOGNISER) as tab,
    ):
        talk = button(tab, "Hold to talk")
        talk.dispatch_event("pointerdown")
        tab.get_by_text("“wait”").wait_for()  # a warning does not wait for the button
        assert talk.get_attribute("aria-pressed") == "true"
        talk.dispatch_event("pointerup")
        tab.get_by_text("“wait, don't cut the duct”").wait_for()
        assert talk.get_attribute("aria-pressed") == "false"
    session.pace.go_on()
    run_to(session, 0.3)
    lines = [line for line in session.watcher.status().lines if line.kind == "said"]
    assert "I hold" in lines[0].detail


def test_a_browser_without_speech_recognition_takes_typed_sentences(chromium, session):
    say_port = choose_port(HOST) + 1
    script = "delete window.SpeechRecognition; delete window.webkitSpeechRecognition;"
    with (
        PageProcess(session, host=HOST, port=choose_port(HOST), say_port=say_port),
        open_tab(chromium, f"http://{HOST}:{say_port}", script=script) as tab,
    ):
        assert button(tab, "Hold to talk").is_disabled()
        type_in(tab, "wait")
        enter(tab)
        tab.get_by_text("“wait”").wait_for()
