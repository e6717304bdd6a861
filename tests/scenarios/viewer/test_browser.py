"""What a person sees and does, in a real browser; screenshots lie beside pytest's other files."""

import io
import math

import numpy as np
import pytest

from controller.dataset.part import read_part
from scenarios.recording.recorder import load
from scenarios.viewer.chromium import browser, button, enter, missing, open_tab, press, type_in
from scenarios.viewer.page_process import PageProcess
from scenarios.viewer.port import choose_port
from tests.scenarios.viewer.sessions import SEED, run_to, session, wait_until
from tissue_sim.tools.arms import RIGHT_ARM

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(bool(missing()), reason=missing() or "there is one"),
]

HOST = "127.0.0.1"
STEP_S = 1 / 30


@pytest.fixture(scope="module")
def chromium():
    with browser() as chromium:
        yield chromium


@pytest.fixture
def desk(tmp_path):
    with session(tmp_path) as desk:
        yield desk


@pytest.fixture
def tab(chromium, desk):
    with (
        PageProcess(desk, host=HOST, port=choose_port(HOST)) as page,
        open_tab(chromium, f"http://{HOST}:{page.port}") as tab,
    ):
        tab.get_by_text("Ready: press Start").wait_for()
        yield tab


def say(tab, text):
    type_in(tab, text)
    enter(tab)


def picture(tab, path):
    """(height, width, 3) of what is on the screen."""
    from PIL import Image

    content = tab.screenshot(path=path)
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)


def share_of_green(picture):
    """Of the screen: the gallbladder is the only large thing that is more green than anything."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return ((green > red + 5) & (green > blue + 15) & (green > 60)).mean()


def recorded(desk):
    """The episode so far: the person's own reset closes it."""
    path = desk.out / "episodes" / f"{SEED}.npz"
    wait_until(path.exists)
    return load(path)


def tip_moved_m(recording, heard, after_s):
    """(3,) of the right tip, endoscope frame, from what was heard on."""
    tips = recording.arrays["tips_endoscope"][:, RIGHT_ARM, :3, 3]
    last = min(heard["step"] + round(after_s / STEP_S), len(tips) - 1)
    return tips[last] - tips[heard["step"]]


def test_the_page_loads_and_the_tissue_is_drawn(tab, tmp_path):
    wait_until(lambda: share_of_green(picture(tab, tmp_path / "loaded.png")) > 0.01)


def test_a_button_moves_the_right_tip_up(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.5)
    press(tab, "move right arm higher")
    wait_until(lambda: desk.watcher.story().instruction.source == "human")
    run_to(desk, desk.watcher.story().time_s + 2.2)
    desk.pace.restart(desk.config)
    (heard,) = recorded(desk).heard
    assert tip_moved_m(recorded(desk), heard, 2.0)[1] >= 0.003


def test_a_sentence_does_what_it_says_and_its_reading_is_shown(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.5)
    say(tab, "a bit to the left with the clip applier")
    wait_until(lambda: desk.watcher.story().instruction.source == "human")
    tab.locator(".reply", has_text="move right arm to the left").wait_for()
    run_to(desk, desk.watcher.story().time_s + 2.2)
    desk.pace.restart(desk.config)
    (heard,) = recorded(desk).heard
    x, y, z = tip_moved_m(recorded(desk), heard, 2.0)
    assert x >= 0.003
    assert max(abs(y), abs(z)) < 0.5 * x


def test_nonsense_is_asked_back_and_nothing_moves_for_it(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.3)
    say(tab, "the moon is made of green cheese")
    tab.locator(".reply", has_text="green cheese").wait_for()
    run_to(desk, desk.watcher.story().time_s + 0.3)
    story = desk.watcher.story()
    assert [line.kind for line in story.lines if "cheese" in line.text] == ["asked back"]
    assert story.instruction.source == "planner"


def test_what_is_unclear_is_asked_back_and_a_guess_is_a_button(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.3)
    say(tab, "up a bit")
    guesses = button(tab, "move left arm higher")  # one of them is among the corrections
    wait_until(lambda: guesses.count() == 2)
    assert desk.watcher.story().instruction.source == "planner"
    guesses.last.dispatch_event("click")
    wait_until(lambda: desk.watcher.story().instruction.source == "human")
    assert desk.watcher.story().instruction.text == "move left arm higher"


def test_a_pause_holds_a_step_is_one_and_it_goes_on(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.5)
    press(tab, "Pause")
    wait_until(lambda: desk.pace.paused)
    tab.wait_for_timeout(300)
    held_s = desk.watcher.story().time_s
    tab.wait_for_timeout(1000)
    assert desk.watcher.story().time_s == held_s
    press(tab, "Step")
    run_to(desk, held_s + 0.5 * STEP_S)
    tab.wait_for_timeout(300)
    assert desk.watcher.story().time_s == pytest.approx(held_s + STEP_S)
    press(tab, "Go on")
    run_to(desk, held_s + 1.0)


def test_reset_begins_anew_with_the_seed_that_is_set(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.5)
    tab.get_by_text("New patient").click()
    seed = tab.get_by_text("seed", exact=True).locator("xpath=../../..").locator("input")
    seed.fill(str(SEED + 7))
    tab.wait_for_timeout(300)
    before = desk.watcher.patient
    press(tab, "Reset")
    wait_until(lambda: desk.watcher.patient is not before)
    assert desk.watcher.patient.anatomy.seed == SEED + 7


def test_a_reload_and_a_second_tab_keep_the_episode(chromium, tab, desk, tmp_path):
    press(tab, "Start")
    run_to(desk, 0.5)
    patient = desk.watcher.patient
    tab.reload()
    with open_tab(chromium, tab.url) as other:
        for each in (tab, other):
            each.get_by_text("grabbing gallbladder").first.wait_for()
        run_to(desk, desk.watcher.story().time_s + 0.5)
        assert desk.watcher.patient is patient
        wait_until(lambda: share_of_green(picture(other, tmp_path / "second.png")) > 0.01)
        press(other, "Pause")
        wait_until(lambda: desk.pace.paused)
        button(tab, "Go on").wait_for()


def test_saving_an_intervention_makes_a_loadable_episode(tab, desk):
    press(tab, "Start")
    run_to(desk, 0.3)
    press(tab, "move left arm lower")
    save = "Save this intervention as training data"
    tab.locator(f'button:enabled:has-text("{save}")').wait_for()
    run_to(desk, desk.watcher.story().time_s + 0.5)
    press(tab, save)
    wait_until(lambda: list(desk.out.glob("interventions/parts/*.parquet")))
    (path,) = desk.out.glob("interventions/parts/*.parquet")
    assert "move left arm lower" in read_part(path).columns["correction"]


def test_keys_do_what_the_legend_says(tab, desk):
    tab.keyboard.press("Space")
    wait_until(lambda: not desk.pace.paused)
    tab.keyboard.press("Shift+KeyI")
    wait_until(lambda: desk.watcher.story().instruction.text == "move left arm higher")
    tab.keyboard.press("KeyH")
    wait_until(lambda: desk.watcher.story().instruction.hold)


def test_an_arm_that_is_taken_over_is_the_persons_until_it_is_given_back(tab, desk):
    press(tab, "Start")
    tab.get_by_text("Take over an arm").click()
    press(tab, "Take the right")
    wait_until(lambda: desk.watcher.story().hand == RIGHT_ARM)
    press(tab, "Give it back")
    wait_until(lambda: desk.watcher.story().hand is None)


def test_an_exported_page_works_offline(chromium, tmp_path, desk):
    from scenarios.viewer.export import export
    from scenarios.viewer.recording_frames import RecordingFrames

    desk.pace.speed = math.inf
    desk.pace.go_on()
    run_to(desk, 8.0)  # it is played over and over, and fades in each time
    desk.pace.restart(desk.config)
    page = tmp_path / "page.html"
    page.write_text(export(RecordingFrames(recorded(desk), every=6), lambda time_s: None))
    with open_tab(chromium, page.as_uri(), offline=True) as tab:
        wait_until(lambda: share_of_green(picture(tab, tmp_path / "exported.png")) > 0.01)
