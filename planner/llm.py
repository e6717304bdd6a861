"""Use a language model as planner: it reads the scene in words and answers with an instruction.

Simulated time stops while the model answers, so an episode does not depend on the model's speed.
After an answer that cannot be followed, both arms hold, and the instruction gives the reason. If no
model can answer, the episode ends in an error.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from planner.base import PATIENCE_S
from planner.chat_client import ChatClient, NonsenseError, object_in
from planner.chat_endpoint import Endpoint, endpoint_from_environment
from planner.correction import CORRECTIONS, Correction, correction_from_text
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from planner.procedure.cholecystectomy import GRAB, TASKS, task_from_text
from planner.procedure.task import Task
from planner.scene.in_words import scene_in_words
from tissue_sim.outcome.clip_rule import needed_m
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.instruments import appliers

SMALL, LARGE = appliers()
ATTEMPTS = 3  # at an answer that can be followed
REMEMBERED = 8  # past instructions that are repeated in each question
NONE = "none"

SCHEMA: dict[str, Any] = {
    "type": "object",
    "properties": {
        "reason": {"type": "string"},
        "task": {"type": "string", "enum": [task.text for task in TASKS]},
        "correction": {"type": "string", "enum": [NONE, *(c.text for c in CORRECTIONS)]},
        "confidence": {"type": "number"},
    },
    "required": ["reason", "task", "correction", "confidence"],
    "additionalProperties": False,
}
"""The JSON schema of an answer: the closed set of 25 tasks and 18 corrections."""

SYSTEM = f"""\
You are the surgeon who directs a two-armed robot through the clipping and cutting of a \
gallbladder removal. Once a second you are told what is seen, and say what to do next. The left \
arm holds a grasper, the right arm a clip applier or scissors; an assistant changes the right tool \
when the task needs another and the arm is back.

The tasks in their order, the left tube first; those of the third tube only where one is seen:
{chr(10).join(f"{task.index}. {task.text}" for task in TASKS)}

A tube of up to 4 mm across takes small clips. Below {1e3 * needed_m("duct", SMALL):.0f} mm (the \
duct) or {1e3 * needed_m("artery", SMALL):.0f} mm (the artery) it has no room for three: leave its \
second clip out. A wider tube takes large clips, three from {1e3 * needed_m("duct", LARGE):.0f} mm.

Task 1 is done when the grasper has held the gallbladder for a second and both tubes are pulled \
straight. A clip is done when it is seen on its tube; going back, when the right tip is at least \
15 mm from all tubes; a cut, when the tube is in two parts. Say a task until it is done, then the \
next. Where a clip or a cut has not succeeded after {PATIENCE_S:g} s, say the going back that \
follows it, then the task again.

A correction takes the place of the task in what the robot hears, and makes a small motion. Give \
one only where the robot is visibly failing, for a second or two; else "{NONE}".

Answer with JSON alone: "reason" (a short sentence), "task", "correction", "confidence" (0 to 1)."""


class PlannerLlm:
    """Asks an endpoint once for each instruction, and again after an invalid answer."""

    def __init__(self, endpoint: Endpoint, sleep: Callable[[float], None] = time.sleep) -> None:
        """Take an endpoint, and `sleep` to wait before repeated requests."""
        self._client = ChatClient(endpoint, SCHEMA, sleep)
        self.reset()

    def reset(self) -> None:
        """Forget the past instructions."""
        self._task = GRAB
        self._said: deque[tuple[float, str]] = deque(maxlen=REMEMBERED)
        self._confused = False

    def plan(self, observation: Observation) -> Instruction:
        """Return the model's instruction, or a hold if its answer cannot be followed.

        Raises:
            EndpointError: No model answers.
        """
        now_s = observation.time_s
        try:
            task, correction, confidence, reason = self._answer(observation)
        except NonsenseError as error:
            self._confused = True
            remark = f"{self._client.endpoint.name}: {error}"
            return Instruction(task=self._task, hold=True, time_s=now_s, remark=remark)
        self._confused, self._task = False, task
        instruction = Instruction(
            task=task, correction=correction, confidence=confidence, time_s=now_s, remark=reason
        )
        self._remember(instruction)
        return instruction

    def _answer(self, observation: Observation) -> tuple[Task, Correction | None, float, str]:
        """Return the first answer that can be followed; after a hold the model is asked once."""
        question = self._question(observation)
        for _ in range(0 if self._confused else ATTEMPTS - 1):
            with suppress(NonsenseError):
                return parse_answer(self._client.ask(SYSTEM, question))
        return parse_answer(self._client.ask(SYSTEM, question))

    def _question(self, observation: Observation) -> str:
        said = "\n".join(f"{time_s:.0f} s: {text}" for time_s, text in self._said)
        return f"{scene_in_words(observation)}\n\nYou said, from when on:\n{said or 'nothing yet'}"

    def _remember(self, instruction: Instruction) -> None:
        if not self._said or self._said[-1][1] != instruction.text:
            self._said.append((instruction.time_s, instruction.text))


def parse_answer(text: str) -> tuple[Task, Correction | None, float, str]:
    """Return task, correction, confidence and reason of an answer.

    Raises:
        NonsenseError: No part of the answer keeps `SCHEMA`; additional keys are allowed.
    """
    answer = object_in(text, SCHEMA["required"])
    said, confidence = answer["correction"], answer["confidence"]
    if isinstance(confidence, bool) or not isinstance(confidence, int | float):
        raise NonsenseError(f"confidence must be a number, got {confidence!r:.80}")
    if not 0.0 <= confidence <= 1.0:
        raise NonsenseError(f"confidence must be 0 to 1, got {confidence}")
    try:
        task = task_from_text(answer["task"])
        correction = None if said == NONE else correction_from_text(said)
    except (ValueError, TypeError) as error:
        raise NonsenseError(f"its answer is outside the set: {str(error)[:80]}") from None
    return task, correction, float(confidence), " ".join(str(answer["reason"]).split())[:200]


def require_answer(endpoint: Endpoint) -> None:
    """Ask a question with an irrelevant answer, to check that a model answers.

    Raises:
        EndpointError: No model answers.
    """
    with suppress(NonsenseError):
        ChatClient(endpoint, SCHEMA).ask(SYSTEM, "Nothing is seen yet: say task 1.")


def make(setup: PolicySetup) -> PlannerLlm:
    """Return the planner for the endpoint that the environment names.

    Raises:
        ValueError: The environment names no endpoint, or a wrong one.
    """
    del setup
    return PlannerLlm(endpoint_from_environment())
