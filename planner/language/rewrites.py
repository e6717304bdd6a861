"""Turns of phrase that say in many words what the lexicon knows in few, or nothing at all."""

from __future__ import annotations

import re

_NUMBER = r"(\d+([.,]\d+)?|an?|half an?|one|two|three|four|five|six|ten|a few|a couple of|some)"
_EYES = "(me|us|camera|scope|endoscope|laparoscope|lens|screen|surgeon|viewer|myself)"
_JAWS = "(arm|hand|instrument|tool|gripper|grasper|jaw|forcep)s?"
_TUBE = "(tube|vessel|structure|pipe|one)"
_NOT_OF = r"(?<!\bit)(?<!\blet)(?<!hat)(?<!\bwho)(?<!ere)(?<!\bhow)(?<!\bhe)(?<!\bshe)"

AS_TYPED = (  # while commas are there
    (r"’", "'"),
    (rf"{_NOT_OF}'s (?=(jaw|tip|grip|blade|end|clip|first|second|third|last|final)s?\b)", " "),
    (rf"{_NOT_OF}'s\b", " 's"),
    (rf"\b(by )?{_NUMBER}\s*(more )?(mm|cm|mils?|millis?|(mill?i|centi)met(er|re)s?)\b", " "),
    (r"#\s*(?=\d)", "number "),
    (r"^((ok|okay|so|and|oh|ah|well|very) )*((right|good|great|perfect|nice|fine|excellent|lovely|super|cool"
     r"|all ?right|well done|(no|nope|nah)( no)*|oops|whoops|sorry|wrong|actually|what's next|next up|ready"
     r"|you('re| are) (good|fine|clear|ok)( to go)?|(that )?looks good|good job|nice one|beautiful|ok|okay"
     r")[,.!;:?]+ *)+", ""),
)  # fmt: skip
"""Patterns, each with what is said instead."""

AS_SAID = (  # words only
    (r"\b(u|ya)\b", "you"), (r"\b2 (?=(me|us)\b)", "to "),
    (r"\b(goto|go2)\b", "go to"), (r"\bgo ?ba(c|k)k?\b", "go back"), (r"\bmv\b", "move"),
    (r"\b(lft|lef|l)(?= [a-z])", "left"), (r"\b(rgt|rt|rite|r)(?= [a-z])", "right"), (r"\bfrm\b", "from"),
    (r"\bnxt\b", "next"), (r"\bbck\b", "back"),
    (r"^i (did not|didn't) (want|mean|ask for|say) (that|this|it|so)( to happen)?\b", ""),
    (r"\b(let|set|turn) (gallbladder|tissue) (go|free|loose)\b", "let go gallbladder"),
    (r"\bundo (?=(both|left|right) (jaw|grip))", "open "),
    (r"\b(that|this|those|these) (?!right (now|away|there))(?=(left|right|first|second|third|last|gallbladder|gb|duct|artery"
     r"|cystic|tube|clip|grasper|scissors|arm)\b)", ""),
    (r"\b(duct|artery|tube|one|structure)( 's| is) (up )?next\b", r"\1"),
    (r"\b(drift|creep|stray|wander|slipp|slid|veer|go)ing (off |too far )?(to )?(?=(left|right|up|down|in|out|high|low|deep)"
     r"\b.*\b(bring|come|correct|move|pull|push)\b)", "too "),
    (r"\b((neck|body|fundus|wall|dome) of |(the )?gallbladder )?((gal+|goal|gold(en)?|call|ball|gull|gaul)"
     r" ?bl?add?e?r|gb|infundibulum|fundus|hartmanns?( pouch)?)( neck| tissue| wall| body| fundus)?\b", "gallbladder"),
    (r"\b(take|get|have|collect|pick( up)?|picking( up)?|taking|getting|catch|clasp)( yourself)?( an?)?"
     r"( good| firm| decent| better| gentle| proper| nice)?( (hold|bite) (of|on)| grip (of|on))? gallbladder\b", "grab gallbladder"),
    (rf"\b(first|second|1st|2nd|3rd|third)( cystic)? (tube|vessel|structure|pipe|{_JAWS})\b", "fourth"),
    (r"^(good|great|perfect|nice|fine|excellent|lovely|super|cool|right|beautiful)"
     r" (?=(now|so|then|and|ok|okay|let's|lets|please|next)\b)", ""),
    (r"\b(if|when|whenever|once|as soon as)( ever)? (you( are|'re) (ready|happy)( to)?|you (would|could|please"
     r"|like|wish|must)( please| be so (kind|good)( as to)?| like| mind)*|you (do not|don't|wouldn't) mind"
     r"|that('s| is) (ok|okay|alright|all right)|it('s| is) not too much trouble|you('d| would) (like|be so"
     r" kind( as to)?)|you (get|have) (a|the) (chance|moment|second|sec|minute|time)|(you can|convenient)$)", " "),
    (r"\b((if|when|as soon as) possible|no (rush|hurry|problem|worries|need to (rush|hurry)))\b", ""),
    (r"\b(do|would|could|will|can) you( please)? (mind|be so (kind|good)( as)?|be (kind|good)"
     r" enough|be a (dear|darling|star))( and| to)?\b", "please"),
    (r"\bdo me a favou?r( and)?\b", "please"),
    (r"(?<=\w) (you're|you are) (doing )?(fine|great|good|well|ok|okay|there)$", ""),
    (r"\b(high|low|deep)(er)? (up|down|in)\b", r"\1\2"),
    (r"(?<=clip) (next to|beside|above|below|alongside|past|beyond|behind|near) (first|second|last|others?)( one| clip| two)?\b", ""),
    (r"\b(put|pop|place|get|stick|apply|throw|fire) one (?=(on|to|onto|across|over)\b)", "clip "),
    (r"\bline (\w+ )up\b", r"line up \1"),
    (r"\b(scissors|shears) (right |straight )?(through|across)\b", "cut"),
    (r"(?<=\w) (because|cause|cos|so that|as (it|you|that)('s| is|'re| are)"
     r"|so (i|we) (can|could|have|get)|to (get|have|give|improve) .*(view|look|angle|access|room)"
     r"|for (a )?better) .*$", ""),
    (r"\bthat( is|'s) (it|right|all|the one|better|good)$|(?<=\w) that is$", ""),
    (r"\b(what(ever)?|thing|move|step|one|action|command)( that)? you( have|'ve)?( just)? (did|done"
     r"|made)\b", "last"),
    (r"\b(of )?what(ever)? (it's|it is|you( have| are|'ve|'re)?( got)?) ?(hold|holding|grabbed|got|"
     r"gripping|grasping)\b", "it"),
    (r"\ba (?=(first|second|third) clip)", ""),
    (r"\bwhere (you|we|it|i)( will|'ll| are|'re|'s| is| want)?( going| gonna)?( to)?( be)? (cut|divide|transect)"
     r"(ting)?( it)?\b", "cutting position"),
    (rf"\b{_TUBE}( that| which)?( is|'s)? (on|to|at) ((my|left|right) )?(?=left|right)", r"\1 on \5"),
    (r"\bleft( one)? (and|&|plus) right( one)?\b|\bright( one)? and left( one)?\b", "both"),
    (r"\b(?:((you|it|that)(('re|'s)| are| is) )?not|is not|isn't|ain't|are not|aren't)\b(.*)\benough\b( to)?", r"\5"),
    (r"\b(do not|don't) (go|be|get|come|move|sit)( in)? (so|too|that|as|quite so)( far)? (?=deep|high|low|left|right|close|near"
     r"|in\b|out\b|up\b|down\b)", "too "),
    (r"\b(increase|raise|more) (height|elevation|altitude)\b", "raise"),
    (r"\b(decrease|reduce|lower|less) (height|elevation|altitude)\b", "lower"),
    (r"\b(increase|more) (depth|insertion|distance)\b", "deeper"),
    (r"\b(decrease|reduce|less) (depth|insertion)\b", "shallower"),
    (r"\b(in|inside|out|up|down|left|right|high|low|deep|forward|over|back)( over)? (too (far|much)"
     r"|a bit much)\b", r"too \1"),
    (r"\b(in|inside|down|up|out|over) too (?=deep|low|high|left|right|close|near|far)", "too "),
    (r"(?<!\w)(is|'s|you're|sits|sitting|riding|looks|are|'re) (only )?(just )?(a (bit|little|touch|tad|shade|hair|smidge|fraction)"
     r"|slightly|rather|quite|somewhat)( on)?( the)? (?=(high|low|deep|shallow)( side)?($| (on|with|so|and|can|bring|come|take|push|pull|lower|raise|back|ease)\b))", "too "),
    (r"\b(close|closer|near|nearer|next|up)( in)? to (?=(my )?" + _EYES + r"\b)", "near to "),
    (r"\btoo (close|near|far|tight up)( up| in)?( to| on| from)?( my)? " + _EYES + r"\b",
     r"too \1 me"),
    (r"\btoo (close|near)\b( me\b)?", "too near"),
    (rf"\b((clos|near)(e|er)|near|back)( in)?( up)?( to)? (my )?{_EYES}\b", "towards me"),
    (rf"\b(to|towards?)( my)? {_EYES}\b", "towards me"),
    (rf"\b((further|farther|far|out|deeper) )?(away|off|from|away from|off from) (my )?{_EYES}\b",
     "away from me"),
    (rf"\bclamp( down)?( on| with)? (?=(left|right|both) {_JAWS}|grasper)", "close "),
)  # fmt: skip
"""Patterns, each with what is said instead."""


def rewritten(text: str, rules: tuple[tuple[str, str], ...]) -> str:
    """The text after one rule after the other."""
    for pattern, instead in rules:
        text = re.sub(pattern, instead, text)
    return text
