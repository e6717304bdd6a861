"""Rules that shorten long phrases to words of the lexicon, or remove them.

Each is a pattern and its replacement; they are applied in order.
"""

from __future__ import annotations

import re

Rules = tuple[tuple[str, str], ...]

_NUMBER = r"(\d+([.,]\d+)?|an?|half an?|one|two|three|four|five|six|ten|a few|a couple of|some)"
_UNIT = "(mm|cm|mils?|millis?|(mill?i|centi)met(er|re)s?)"
_EYES = "(me|us|camera|scope|endoscope|laparoscope|lens|screen|surgeon|viewer|myself)"
_JAWS = "(arm|hand|instrument|tool|gripper|grasper|jaw|forcep)s?"
_TUBE = "(tube|vessel|structure|pipe|one)"
_OF_TUBE = "((left|right) (tube|vessel|structure)|(cystic )?(duct|artery))"
_LEVEL = "(high|low|deep|shallow)"
_WAY = "(left|right|up|down|in|out|high|low|deep)"
_VERB = "(raise|lower|lift|bring|move|pull|push|take|drop|open|close|ease|come|back|correct)"
_BIT = "(a (bit|little|touch|tad|shade|hair|smidge|fraction)|slightly|rather|quite|somewhat)"
_NO_VERB = r"(?<!\bit)(?<!\blet)(?<!hat)(?<!\bwho)(?<!ere)(?<!\bhow)(?<!\bhe)(?<!\bshe)"
_PRAISE = "right|good|great|perfect|nice|fine|excellent|lovely|super|cool|beautiful"
_GALLBLADDER = (
    r"((gal+|goal|gold(en)?|call|ball|gull|gaul) ?bl?add?e?r|gb|infundibulum|fundus"
    r"|hartmanns?( pouch)?)"
)
_COMMAND = "(instruction|command|order|action|move|movement|motion|step|thing|task|operation|bit)"

AS_TYPED: Rules = (  # before punctuation is removed
    (r"’", "'"),
    (rf"{_NO_VERB}'s (?=(jaw|tip|grip|blade|end|clip|first|second|third|last|final)s?\b)", " "),
    (rf"{_NO_VERB}'s\b", " 's"),
    (rf"\b(by )?{_NUMBER}\s*(more )?{_UNIT}\b", " "),
    (r"#\s*(?=\d)", "number "),
    (r"(?<!re )\bready(?=[,.;:])", " "),
    (rf"^((ok|okay|so|and|oh|ah|well|very) )*(({_PRAISE}|all ?right|well done|(no|nope|nah)( no)*"
     r"|oops|whoops|sorry|wrong|actually|what's next|next up|ready|good job|nice one|not like that"
     r"|you('re| are) (good|fine|clear|ok)( to go)?|(that )?looks good"
     r"|that('s| is| was|'s not| was not| wasn't) (right|wrong|it)|ok|okay)[,.!;:?]+ *)+", ""),
)  # fmt: skip

_SHORT: Rules = (
    (r"\b(u|ya)\b", "you"),
    (r"\b2 (?=(me|us)\b)", "to "),
    (r"\b(goto|go2)\b", "go to"),
    (r"\bgo ?bac?k?\b", "go back"),
    (r"\bmv\b", "move"),
    (r"\b(lft|lef|l)(?= [a-z])", "left"),
    (r"\b(rgt|rt|rite|r)(?= [a-z])", "right"),
    (r"\bfrm\b", "from"),
    (r"\bnxt\b", "next"),
    (r"\bbck\b", "back"),
)

_POLITE: Rules = (
    (rf"^({_PRAISE}) (?=(now|so|then|and|ok|okay|let's|lets|please|next)\b)", ""),
    (r"\b(if|when|whenever|once|as soon as)( ever)?"
     r" (you( are|'re) (ready|happy)( to)?"
     r"|you (would|could|please|like|wish|must)"
     r"( please| be so (kind|good)( as to)?| like| mind)*"
     r"|you('d| would) (like|be so kind( as to)?)"
     r"|you (do not|don't|wouldn't) mind"
     r"|you (get|have) (a|the) (chance|moment|second|sec|minute|time)"
     r"|that('s| is) (ok|okay|alright|all right)"
     r"|it('s| is) not too much trouble"
     r"|(you can|convenient)$)", " "),
    (r"\b(if|when|as soon as) possible\b", ""),
    (r"\bno (rush|hurry|problem|worries|need to (rush|hurry))\b", ""),
    (r"\b(do|would|could|will|can) you( please)?"
     r" (mind|be so (kind|good)( as)?|be (kind|good) enough|be a (dear|darling|star))"
     r"( and| to)?\b", "please"),
    (r"\bdo me a favou?r( and)?\b", "please"),
    (r"^we can( now)? (?=(move on|go on|proceed|continue|carry on)\b)", ""),
    (r"^i (did not|didn't) (want|mean|ask for|say) (that|this|it|so)( to happen)?\b", ""),
    (r"(?<=\w) (you're|you are) (doing )?(fine|great|good|well|ok|okay|there)$", ""),
    (r"\bthat( is|'s) (it|right|all|the one|better|good)$|(?<=\w) that is$", ""),
    (r"(?<=\w) (because|cause|cos|so that|as (it|you|that)('s| is|'re| are)"
     r"|so (i|we) (can|could|have|get)"
     r"|to (get|have|give|improve) .*(view|look|angle|access|room)|for (a )?better) .*$", ""),
)  # fmt: skip

_LAST: Rules = (  # the last action or command, and what the jaws hold
    (rf"\b(my )?(previous|last|latest|prior|most recent|preceding)( {_COMMAND}\b|(?= you\b)| *$)",
     "last"),
    (rf"\b(last|what(ever)?|one|{_COMMAND})( that)? you( have|'ve)?( just)? (did|done|made)\b",
     "last"),
    (r"\b(back|return) to (how|where|way) (it|things|you|that|we|everything|they)"
     r" (was|were|had been|used to be)\b", "undo"),
    (r"\b(of )?what(ever)? (it's|it is|you( have| are|'ve|'re)?( got)?) ?"
     r"(hold|holding|grabbed|got|gripping|grasping)\b", "it"),
)  # fmt: skip

_THINGS: Rules = (
    (r"\b(that|this|those|these) (?!right (now|away|there))"
     r"(?=(left|right|first|second|third|last|gallbladder|gb|duct|artery|cystic|tube|clip|grasper"
     r"|scissors|arm)\b)", ""),
    (rf"\b((neck|body|fundus|wall|dome) of |gallbladder )?{_GALLBLADDER}"
     r"( neck| tissue| wall| body| fundus)?\b", "gallbladder"),
    (r"\b(take|get|have|collect|pick( up)?|picking( up)?|taking|getting|catch|clasp|secure|engage"
     r"|snare|trap|hang on to|(get|put|close|clamp) (jaws|grasper|forceps|tips)"
     r" (on|around|onto|over))( yourself)?( an?)?"
     r"( good| firm| decent| better| gentle| proper| nice)?"
     r"( (hold|bite) (of|on)| grip (of|on))? gallbladder\b", "grab gallbladder"),
    (r"\b(let|set|turn) (gallbladder|tissue) (go|free|loose)\b", "let go gallbladder"),
    (rf"\b(first|second|1st|2nd|3rd|third)( cystic)? (tube|vessel|structure|pipe|{_JAWS})\b",
     "fourth"),  # not a clip: there are three
    (r"\b(take|pull) (out|off) (left |right )?(clip|first|second|third|last)\b"
     r"|\b(take|pull) (\w+ )?clip (out|off|away)\b", "remove"),
    (r"\b(duct|artery|tube|one|structure)( 's| is) (up )?next\b", r"\1"),
    (r"\ba (?=(first|second|third) clip)", ""),
    (rf"\b(finish|round|top|complete|start|begin|open|continue) ({_OF_TUBE}) (off |up |out )?"
     r"(with|by)\b", r"\2"),
    (r"\b(is|'s|are)( now| still| all| just)* ((waiting|due|overdue|crying out|desperate)"
     r" (for|to (have|get|receive|take))|ready for(?=.* (please|apply|place|put|go ahead)\b))\b"
     r"|\bawaits?\b", "needs"),
    (r"\b(what|which)ever clip\b|\bclip( that| which)?( is|'s) (due|next|up)( next| now)?\b"
     r"|\bclip (due|up next)\b", "next clip"),
    (r"\b(next|another|one more|a further)( one)? (?=(on|onto|to|for) (left|right|duct|artery"
     r"|cystic)\b)", "next clip "),
    (r"\bnext clip( that| which)?( is|'s| comes)?( now)? (due|next|up|needed|required|wanted)"
     r"( next| now)?\b", "next clip"),
    (r"\b(in )?between ((its|those|these|two|three|proximal|distal|first|second|last|third|and"
     r"|lower|upper|inner|outer) )*clips?( (one|two|three|1|2|3|and))*\b", ""),
    (rf"\bwhere ({_OF_TUBE}|it)( is|'s| will be| shall be| has to be| needs)?( going)?( to be)? "
     r"(cut|divided|transected|severed|snipped)( off| through)?\b", r"cutting position \1"),
    (r"(?<=clip) (next to|beside|above|below|alongside|past|beyond|behind|near)"
     r" (first|second|last|others?)( one| clip| two)?\b", ""),
    (r"\b(put|pop|place|get|stick|apply|throw|fire) one (?=(on|to|onto|across|over)\b)", "clip "),
    (r"\b(scissors|shears) (right |straight )?(through|across)\b", "cut"),
    (r"\bwhere (you|we|it|i)( will|'ll| are|'re|'s| is| want)?( going| gonna)?( to)?( be)?"
     r" (cut|divide|transect)(ting)?( it)?\b", "cutting position"),
    (rf"\b{_TUBE}( that| which)?( is|'s)? (on|to|at) ((my|left|right) )?(?=left|right)",
     r"\1 on \5"),
    (r"\b(left( one)? and right|right( one)? and left)( one)?\b", "both"),
    (r"\b(line|set) (\w+ )up\b", r"\1 up \2"),
    (r"\bundo (?=(both|left|right) (jaw|grip))", "open "),
    (rf"\bclamp( down)?( on| with)? (?=(left|right|both) {_JAWS}|grasper)", "close "),
    (r"\b(raise|lower|lift|bring|move|pull|push|take|drop|open|close|ease) it\b", r"please \1 it"),
)  # fmt: skip

_TOO: Rules = (  # too much, and not enough
    (r"\b(((you|it|that)('re|'s| are| is) )?not|is not|isn't|ain't|are not|aren't)\b"
     r"(.*)\benough\b( to)?", r"please \5"),
    (r"\b(do not|don't|not)( (go|be|get|come|move|sit)( in)?)? (so|that|quite so)"
     r" (?=(high|low|deep|close|near|up|down)\b)", "too "),
    (rf"\b(drift|creep|stray|wander|slipp|slid|veer|go|rid|sitt|sagg|hang)ing"
     rf" (off |too far )?(to )?(?={_WAY}\b.*\b{_VERB}\b)", "too "),
    (rf"\btoo much (?=({_WAY}|to|on)\b)", "too "),
    (r"\btoo far( away| out)? (from|of) me\b", "too away from me"),
    (r"\b(high|low|deep)(er)? (up|down|in)\b", r"\1\2"),
    (r"\b(in|inside|out|up|down|left|right|high|low|deep|forward|over|back)( over)?"
     r" (too (far|much)|a bit much)\b", r"too \1"),
    (r"\b(in|inside|down|up|out|over) too (?=deep|low|high|left|right|close|near|far)", "too "),
    (rf"(?<!\w)(is|'s|you're|sits|sitting|riding|looks|are|'re) (only )?(just )?{_BIT}( on)?( the)?"
     rf" (?={_LEVEL}( side)?($| (on|with|so|and|can|{_VERB})\b))", "too "),
    (r"\b(increase|raise|more) (height|elevation|altitude)\b", "raise"),
    (r"\b(decrease|reduce|lower|less) (height|elevation|altitude)\b", "lower"),
    (r"\b(of|in|some|gain|with) (extra |more )?(height|elevation|altitude)\b", "higher"),
    (r"\b(increase|more) (depth|insertion|distance)\b", "deeper"),
    (r"\b(decrease|reduce|less) (depth|insertion)\b", "shallower"),
)  # fmt: skip

_TOWARDS: Rules = (
    (rf"\b(close|closer|near|nearer|next|up)( in)? to (?=(my )?{_EYES}\b)", "near to "),
    (rf"\btoo (close|near)( up| in)?( to| on| from)?( my)? {_EYES}\b", r"too \1 me"),
    (r"\btoo (close|near)\b( me\b)?", "too near"),  # no word about the jaws
    (rf"\b((clos|near)(e|er)|near|back)( in)?( up)?( to)? (my )?{_EYES}\b", "towards me"),
    (rf"\b(to|towards?)( my)? {_EYES}\b", "towards me"),
    (rf"\b((further|farther|far|out|deeper) )?(away|off|from|away from|off from) (my )?{_EYES}\b",
     "away from me"),
)  # fmt: skip

AS_SAID: Rules = (*_SHORT, *_POLITE, *_LAST, *_THINGS, *_TOO, *_TOWARDS)  # without punctuation


def rewritten(text: str, rules: Rules) -> str:
    """Apply the rules to a text, in order."""
    for pattern, instead in rules:
        text = re.sub(pattern, instead, text)
    return text
