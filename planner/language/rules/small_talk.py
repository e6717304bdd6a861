"""Talk of meals and journeys, and of progress: no business of the robot's; small_talk.toml."""

from __future__ import annotations

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters


def is_small_talk(text: str) -> bool:
    """Return whether a text names a topic of small talk, or tells only what is done."""
    words, lists = in_plain_letters(text), phrase_lists("small_talk")["small_talk"]
    topic, operation = (whole_words(lists[name]).search(words) for name in ("topics", "operation"))
    progress = whole_words(lists["progress"]).fullmatch(words)
    return (topic is not None and operation is None) or progress is not None
