"""Mend letters and words that are misspelt, as a keyboard or speech recognition spells them.

Letters are taken for what they look like, without hidden ones and spaces between them. Words are
those of the theatre, and of whom a sentence addresses.
"""

from __future__ import annotations

import re
import unicodedata
from functools import cache

from planner.language.rules.phrase_search import phrase_lists, whole_words
from planner.language.rules.warning import warns

_SIDED = r"(?=(?: (?:h?arm|hand|grip+\w*|gra[bs]p?er|jaws?|tube|tool|instrument)s?\b))"
_RULES = (
    (r"\bart(?:e|a|i|u)?r{1,3}(?:y|ie|ee|ey|i)\b|\bart ?tree\b|\bartey\b|\barty\b", "artery"),
    (r"\b(?:duc|duk|duck|dukt|duckt|docked|dock|doct)\b(?! (?:tape|out|down|under))", "duct"),
    (r"\b(?:gal+|gall|gaul|call|goal) ?bl(?:a|e|u)(?:d|t|dd|tt)(?:er|a|ar|or)\b", "gallbladder"),
    (r"\bg(?:r?i|ir)p+e?r(s?)\b", r"gripper\1"),
    (rf"\b(?:write|rite|wright|rihgt|rigth|righ)\b{_SIDED}", "right"),
    (r"\b(left|right)(?:y|ie)? ?h?(arm|hand|gripper)\b", r"\1 \2"),
    (r"\bclip in (?:the )?(?=(?:left|right|cystic|duct|artery)\b)", "clip on "),
    (r"\bto words\b", "towards"),
    (r"\b(?:the )?(?:hand|arm|instrument|tool) (?:that(?: is|'s)? )?"
     r"hold(?:s|ing) (?:on to )?(?:the )?gallbladder\b"
     r"|\bgallbladder(?:'s)? (?:hand|arm)\b", "left arm"),
    (r"\bclip (?:too|to) on\b", "clip two on"),
    (r"\bright (scissors|shears|clip applier|applier|clipper)\b", r"\1"),
    (r"\b(?:have|get) (it|(?:(?:the|your|that|left|right|cystic) )*(?:duct|artery|tube|arm|hand"
     r"|gripper|grasper|jaws|scissors)) (cut|divided|snipped|transected|severed|clipped|opened"
     r"|closed|shut)\b(?! ?\?| (?:yet|already|fully|properly|now))(?: (?:for|by) \w+)?",
     r"please \2 \1"),
    (r",?\s*\b(?:i\.?\s?e\b\.?|that is to say|in other words|meaning|namely),?", ","),
    (r"\bplus (?=\d.*\b(?:up\w*|higher|right\w*|deeper|away)\b)"
     r"|\bminus (?=\d.*\b(?:down\w*|lower|left\w*|towards)\b)", "by "),
    (r"^(?:we|you)(?:'re| are)(?: now)? (?=\w+ing\b.*\b(?:do it|go ahead|please)[.!]*$)", ""),
    (r",\s*(?:my (?:dear|good|old|young|friend)\b[\w ]*|buddy|sweetie|mate|pal|honey|love|darling"
     r"|dear|doc|doctor|chief|boss|sir|madam|robot|friend|amig[oa]|bro|man|dude|guys|folks|son"
     r"|kiddo|champ|please and thank you|if you would|por favor|per favore|bitte)\s*[.!]*$", ""),
    (r",?\s*\b(?:(?:there|that)'?s a |like a )?(?:good|great|dear)"
     r" (?:man|woman|lad|lass|girl|chap|fellow|boy)\b[.!]*$", ""),
    (r",?\s*\b(?:thanks a million|much obliged|thanking you|if you'?d be so (?:kind|good))"
     r"\s*[.!]*$", ""),
    (r",?\s*\blet'?s say,?", " "),
    (r"\bwould it kill you to ", "please "),
    (r"(?<=to the )write\b", "right"),
    (r",?\s*for (?:heaven|god|christ|goodness|pete)'?s sake\b", ""),
    (r",?\s*would be my preference\s*[.!]*$", ""),
    (r"^(?:you've|you have) (?:got )?(?:the|my) (?:go-ahead|green light|permission)[:,]? ?", ""),
    (r"^(?:you are|you're|ur|youre) (?:good|ok|okay|fine|clear|free|welcome) to ", ""),
    (r"^(?:now|so) (?:we|you) (?=(?:clip|cut|divide|open|close|go|move)\b)", ""),
    (r"\b(?:pincers?|jaws?|grippers?|claws?) of (?:the |your )?(left|right) (?:arm|hand)\b",
     r"\1 gripper"),
    (r"\b((?:cut|divide|snip|transect|sever)\b.*?) (?:with|using) (?:the |your )?"
     r"(?:scissors|shears)\b", r"\1"),
    (r"\b((?:clip|clamp)\b.*?) (?:with|using) (?:the |your )?(?:clip applier|applier|clipper)\b",
     r"\1"),
    (r"\b(?:carry on|continue|go on|resume)(?: from)? where (?:you|we) (?:left off|were|stopped)\b",
     "resume"),
    (r"\b(resume|continue) (?:the |your )?(?:trajectory|motion|execution|program\w*)\b", r"\1"),
    (r"\bre-?run\b|\bdo one (?:time more|more time)\b", "repeat"),
    (r"\bre-?gra(?:sp|b)\b", "grab"),
    (r"(?<!to the )(?<!to )(?<!into )\bcut (?:pose|place|point)\b", "cut"),
    (r"(?<!the )(?<!to )(?<!move )(?<!go )(?<!further )(?<!more )(?<!bit )(?<!arm )(?<!mm )"
     r"\bright (?:now|this (?:second|minute|instant))\b", "now"),
    (r"(?<=it )right (?=(?:up|down)\b)", ""),
    (r"^((?!.*\b(?:arm|hand|up|down)\b).*\b(?:clip|cut|divide)\b.*?),\s*(?:all )?right[.!?]*$",
     r"\1"),
    (r"^(?:(?:only|just|still) )?(?:one|two|three|[123])(?: more)? clips? left[.!]*$",
     "there is one clip to do"),
    (r"\b(clips?|cut|one) left (?=to (?:do|go|place|put|clip|cut)\b)", r"\1 remaining "),
    (r"\b(duct|artery|(?:left|right) (?:tube|vessel|structure|one)),? (?:second|last)\b"
     r"(?! (?:clip|one))", r"\1 at some point"),
    (r"^(?:(?:ok|okay|so|now|please),? )*let me"
     r" (?=(?:clip|cut|divide|snip|transect|do|place|put|fire)\b)", "i will "),
    (r"\b((?:cut|divide|snip|transect)\b.*?) (?:on|at) "
     r"(?:three|3|go|my (?:count|mark|signal|command|word))\b", r"\1 when i say so"),
    (r"\bclose enough\b(?! to (?:me|us|my)\b)", "near enough to it"),
    (r"\bclose (?=to\b)", "near "),
    (r"\b((?:come|comes|coming|stay|stays|staying|bring|bringing)"
     r"(?: (?:the|your|left|right|arm|hand|scissors|clip applier|applier|grasper|it))*) close\b"
     r"(?=[.,;!?]|$)", r"\1 near"),
    (r"\b(?:i should|i would|i'd) like (?=(?:the |your )?(?:left|right) (?:arm|hand|gripper))",
     "i want "),
)  # fmt: skip


def as_meant(text: str) -> str:
    """Return a text with the words that are misspelt in known ways as they are meant."""
    for pattern, word in _spellings():
        text = pattern.sub(word, text)
    for pattern, instead in _RULES:
        text = re.sub(pattern, instead, text, flags=re.IGNORECASE)
    return text


@cache
def _spellings() -> tuple[tuple[re.Pattern[str], str], ...]:
    words = phrase_lists("spellings")["words"]
    return tuple((re.compile(whole_words(ps).pattern, re.IGNORECASE), w) for w, ps in words.items())


# Letters

_LOOK_ALIKES = str.maketrans(
    "аеорсухіјѕԁһкмтвнзгԛԝАЕОРСУХІЈЅВНКМТЗαεορικντυχηΑΒΕΖΗΙΚΜΝΟΡΤΥΧϲ",
    "aeopcyxijsdhkmtbh3rqwAEOPCYXIJSBHKMT3aeopikvtuxnABEZHIKMNOPTYXc",
)
_HIDDEN = re.compile(
    r"[\x00-\x08\x0e-\x1f\x7f-\x9f\u00ad\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufeff]"
)
_NO_FRACTION = re.compile("[^½¼¾]+")
_OTHER_LETTERS = re.compile(r"[\u0370-\u1dff\u2c00-\uabff\uac00-\ud7ff]")
_SPACED = re.compile(r"(?<![\w'])(?:[^\W\d_][ .\-_*]{1,2}){2,}[^\W\d_](?![\w'])")


def in_latin(text: str) -> str:
    """Return a text as it is seen: without hidden characters, in Latin letters, words unspaced.

    Letters of another script count as what they look like only where all of the text does.
    """
    if not text.isascii():
        text = _NO_FRACTION.sub(lambda part: unicodedata.normalize("NFKC", part[0]), text)
        plain = text.translate(_LOOK_ALIKES)
        text = text if _OTHER_LETTERS.search(plain) else plain
    return _SPACED.sub(lambda spaced: _joined(spaced[0]), _HIDDEN.sub("", text))


def _joined(spaced: str) -> str:
    """Return a warning that is spelt, "s-t-o-p", as a word; other letters as they are."""
    word = re.sub(r"[ .\-_*]", "", spaced)
    return word if warns(word) else spaced
