"""Sentences built from parts, for the tests of free text, and sets of sentences in files."""

from pathlib import Path

from hypothesis import strategies as st

DEVELOPMENT = Path(__file__).with_name("development.tsv")
HELD_OUT = Path(__file__).with_name("held_out.tsv")
OPPOSITES = {
    "left": "right", "to the left": "to the right", "higher": "lower", "up": "down",
    "deeper": "closer to me",
}  # fmt: skip
DIRECTIONS = [*OPPOSITES, *OPPOSITES.values()]
ARMS = ("left arm", "right arm", "left hand", "right instrument")
PLACES = ("left tube", "right tube", "duct", "artery")

moves = st.builds("{} the {} {}".format, st.sampled_from(["move", "bring", "shift"]),
                  st.sampled_from(ARMS), st.sampled_from(DIRECTIONS))  # fmt: skip
jaws = st.builds("{} the {} gripper".format, st.sampled_from(["open", "close", "squeeze"]),
                 st.sampled_from(["left", "right"]))  # fmt: skip
deeds = st.builds("{} the {}".format, st.sampled_from(["clip", "cut", "divide", "put a clip on"]),
                  st.sampled_from(PLACES))  # fmt: skip
tasks = st.builds("{} {} clip on the {} tube".format,
                  st.sampled_from(["place the", "go back from the"]),
                  st.sampled_from(["first", "second", "third"]),
                  st.sampled_from(["left", "right"]))  # fmt: skip
orders = moves | jaws | deeds | tasks


def mirrored(text: str) -> str:
    """Return the text with left and right exchanged."""
    swap = {"left": "right", "right": "left"}
    return " ".join(swap.get(word, word) for word in text.split())
