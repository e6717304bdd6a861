"""Template sentences to train the slot heads: many wordings of every command, and of none."""

from __future__ import annotations

from itertools import product

from planner.command import COMMANDS, Command
from planner.language.slots import SLOTS

_ARMS = {
    "left": ("left arm", "left hand", "left instrument", "grasper"),
    "right": ("right arm", "right hand", "right instrument", "clip applier"),
}
_GRIPPERS = {
    "left": ("left gripper", "left jaws", "grasper"),
    "right": ("right gripper", "right jaws", "clip applier"),
    "both": ("both grippers", "both pairs of jaws"),
}
_MOTIONS = {
    "left": ("move the {} to the left", "{} more left", "shift the {} sideways to the left"),
    "right": ("move the {} to the right", "{} more right", "shift the {} sideways to the right"),
    "higher": (
        "raise the {}",
        "{} up a bit",
        "hoist the {}",
        "the {} should climb towards the top",
    ),
    "lower": ("lower the {}", "{} down a bit", "sink the {}", "let the {} come towards the bottom"),
    "away": (
        "push the {} deeper",
        "{} away from me",
        "{} further into the patient",
        "advance the {}",
    ),
    "towards": ("pull the {} back", "{} towards me", "bring the {} nearer to us", "{} out a bit"),
}
_JAWS = {
    "open": ("open the {}", "spread the {} apart", "{} wider", "relax the {}", "part the {}"),
    "close": (
        "close the {}",
        "shut the {}",
        "squeeze the {} together",
        "{} tighter",
        "clench the {}",
    ),
}
_DEEDS = {
    "clip": (
        "clip the {}",
        "put a clip on the {}",
        "secure the {} with a clip",
        "clamp off the {}",
    ),
    "cut": ("cut the {}", "divide the {}", "slice through the {}", "snip the {} with the scissors"),
}
_TASKS = {
    "grab": (
        "grab the gallbladder",
        "take hold of the gallbladder",
        "clutch the gallbladder firmly",
    ),
    "clip": (
        "put the {} clip on the {}",
        "{} clip {}",
        "attach the {} clip to the {}",
    ),
    "go_back": ("go back from the {} clip on the {}", "withdraw after the {} clip {}"),
    "cut_position": ("go to the cutting position on the {}", "line up to cut the {}"),
    "go_back_from_cut": (
        "go back from the cut on the {}",
        "retreat after cutting the {}",
    ),
}
_WORDS = {
    "stop": ("stop", "halt at once", "stop moving immediately", "quit moving"),
    "pause": ("pause", "wait a moment", "hold on a second", "take a short break"),
    "resume": ("continue", "carry on", "resume the procedure", "you may go on working"),
    "repeat": ("repeat that", "do the same once more", "again please", "run that again"),
    "undo": ("undo that", "take back the last command", "revert the last action"),
    "next step": ("next step", "go to the next task", "move on", "on with the following step"),
    "let go": ("let go", "release the gallbladder", "drop what you hold"),
}  # fmt: skip
_ORDINALS = {"1": "first", "2": "second", "3": "third"}
_TUBES = {"left": "left tube", "right": "right tube", "duct": "duct", "artery": "artery"}
_FRAMES = ("{}", "please {}", "could you {} slightly", "{} now", "you can {} for me", "ok robot {}")

_OTHER_DEEDS = (
    "irrigate", "cauterize", "dissect", "peel", "staple", "suture", "inspect", "remove", "rotate",
    "burn", "measure", "photograph", "stretch", "inject", "drain", "biopsy", "mark", "clean",
    "scrape", "tie", "stitch", "dye", "tear", "describe", "sharpen", "unload", "test", "sterilise",
    "kiss", "bend", "draw", "touch", "massage", "map", "freeze", "cool", "resect", "graft", "crush",
    "dilate", "palpate", "expose", "skeletonise", "hide", "follow", "highlight", "delete", "learn",
    "hate", "mention", "question", "feel", "glue", "hang", "wrap", "unclip", "plug", "buy", "drop",
    "protect", "keep", "mobilise", "free",
)  # fmt: skip
_THINGS = (
    "left tube", "right tube", "duct", "artery", "left arm", "right arm", "left gripper", "clip",
    "gallbladder", "liver", "camera", "bleeding", "right hand", "scissors", "both grippers",
    "first clip on the left tube", "third clip on the right tube",
)  # fmt: skip
_OTHER_FRAMES = (
    "do not {}", "why did you {}", "should we {}", "the nurse will {}", "if it bleeds {}",
    "i would never {}", "imagine you {}", "it was nice how you {}", "yesterday we had to {}",
    "in the video they {}", "is it dangerous to {}",
)  # fmt: skip
_ELSEWHERE = (
    "clip your nails", "cut the budget", "open the window on the left", "close the right drawer",
    "raise the table", "lower the lights", "move the camera to the left", "grab a coffee",
    "grab the bowel", "clip the liver", "cut the suture", "open the abdomen", "lift the liver",
    "left lobe", "right hepatic duct", "the left monitor is dark", "my right hand is tired",
    "turn left at the corner", "hold the retractor", "pull the curtain", "back to the office",
)  # fmt: skip


def wordings(command: Command) -> list[str]:
    """Return wordings of a command."""
    said = SLOTS[command.text]
    kind, what = said["kind"], said.get("what", "")
    if kind == "move":
        made = [m.format(arm) for m, arm in product(_MOTIONS[what], _ARMS[said["arm"]])]
    elif kind in _JAWS:
        made = [m.format(name) for m, name in product(_JAWS[kind], _GRIPPERS[said["arm"]])]
    elif command.deed:
        made = [m.format(_TUBES[said["tube"]]) for m in _DEEDS[kind]]
    elif command.task:
        names = [name for name in (_ORDINALS.get(what), _TUBES.get(said.get("tube", ""))) if name]
        made = [m.format(*names) for m in _TASKS[kind]]
    else:
        made = list(_WORDS[kind])
    return [frame.format(text) for text in (command.text, *made) for frame in _FRAMES]


def other_sentences() -> list[str]:
    """Return sentences that mean no command."""
    deeds = [f"{deed} the {thing}" for deed, thing in product(_OTHER_DEEDS, _THINGS)]
    framed = [frame.format(text) for frame, text in product(_OTHER_FRAMES, COMMANDS)]
    return [*deeds, *framed, *_ELSEWHERE]
