"""Interpret a command as an order: its meaning at the moment of the command."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from planner.command import Command
from planner.correction import CORRECTIONS, Arm, correction_from_text, opposite
from planner.language.reading import Relative, Said
from planner.language.rules.sizes import out_of_range
from planner.person.orders import Order
from planner.person.prohibition import Prohibition, act_of
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.scene.duct_side import duct_side, tube_of
from planner.scene.next_task import NotNowError, next_task, require_there
from tissue_sim.sensing.observation import Observation

OTHER_ARM: dict[Arm, Arm] = {"left": "right", "right": "left"}
LET_GO = correction_from_text("open left gripper")  # the only tool that holds tissue for long


@dataclass(frozen=True, kw_only=True)
class Moment:
    """The moment at which a command is given.

    Attributes:
        task: The task in force.
        ordered: The task of the order in force; None without an order, and in a hold.
        latest: The last order, or the planner's later instruction; "repeat" and "undo" refer to it.
        corrected: The person's last order if it is a correction; "half that" refers to it.
        procedure: The procedure under way.
        gone_m: Distance by which the last order has moved an arm, which "undo" takes back. None if
            no person's word moved an arm.
    """

    observation: Observation
    task: Task
    ordered: Task | None
    latest: Order
    corrected: Order | None = None
    gone_m: float | None = None
    procedure: Procedure = CHOLECYSTECTOMY


def order_of(said: Said, moment: Moment) -> Order:
    """Return the order that a command to act means now.

    Raises:
        NotNowError: The order cannot be carried out now, or a structure is not on the named side.
    """
    _require_side(said, moment.observation)
    if said.relative is not None:
        order = relative_to(moment.corrected, said.relative, said.size_m)
    else:
        order = _to_act(said.command.seen(duct_side(moment.observation)), moment)
        order = order if said.size_m is None else replace(order, distance_m=said.size_m)
    if order.correction:
        return replace(order, task=moment.ordered)
    require_there(order.task and order.task.tube, moment.observation)
    return order


def relative_to(latest: Order | None, said: Relative, size_m: float | None = None) -> Order:
    """Return the correction that refers to the latest one: "half that", "the other one".

    Raises:
        NotNowError: There is no latest correction, or no correction with the wanted relation.
    """
    like = latest and latest.correction
    if latest is None or like is None:
        raise NotNowError("there is no correction to go by; say which arm, and which way")
    way = opposite(like) if said.direction == "opposite" else like
    direction = way.direction if said.direction in (None, "opposite") else said.direction
    arm = OTHER_ARM.get(like.arm) if said.arm == "other" else said.arm or like.arm
    alike = (c for c in CORRECTIONS if (c.arm, c.direction, c.jaw) == (arm, direction, way.jaw))
    if (correction := next(alike, None)) is None:
        raise NotNowError(f"{like.text!r} came before; say which arm, and which way")
    distance_m = said.times * latest.distance_m if size_m is None else size_m
    if why := out_of_range(distance_m):
        raise NotNowError(why)
    return replace(latest, correction=correction, distance_m=distance_m)


def acts_of(order: Order, observation: Observation) -> Iterator[Prohibition]:
    """Yield the acts of an order that a person may have forbidden."""
    if order.correction is None:
        if order.task is not None and (act := act_of(order.task, observation)) is not None:
            yield act
    elif order.correction.jaw == "open":
        arm = order.correction.arm
        for side in ("left", "right") if arm == "both" else (arm,):
            yield Prohibition(act="open", on=f"{side} gripper")


def _to_act(command: Command, moment: Moment) -> Order:
    if command.task is not None:
        return Order(task=command.task)
    if command.correction is not None:
        return Order(correction=command.correction)
    if command.deed is not None and command.tube is not None:
        return Order(task=next_task(command.deed, command.tube, moment.observation))
    if command.word == "repeat":
        return moment.latest
    if command.word == "undo":
        return _to_undo(moment)
    if command.word == "let go":
        return Order(correction=LET_GO)
    return Order(task=_neighbour(moment, moment.task, 1))


def _to_undo(moment: Moment) -> Order:
    latest = moment.latest
    if latest.correction is not None:
        distance_m = latest.distance_m if moment.gone_m is None else max(moment.gone_m, 0.0)
        return replace(latest, correction=opposite(latest.correction), distance_m=distance_m)
    return Order(task=_neighbour(moment, latest.task or moment.task, -1))


def _require_side(said: Said, observation: Observation) -> None:
    structure = said.command.structure
    tube = structure and tube_of(structure, observation)
    if said.side and tube and said.side != tube:
        raise NotNowError(f"the {structure} is the {tube} tube here; say which you mean")


def _neighbour(moment: Moment, task: Task, n: int) -> Task:
    """Return the task before (n = -1) or after (n = 1) a task, of those that the patient has."""
    tasks = moment.procedure.tasks_with(moment.observation.tubes)
    after = [one for one in tasks if (one.index - task.index) * n > 0]
    if not after:
        raise NotNowError(f"{task.text!r} is the {'last' if n > 0 else 'first'} task")
    return after[0 if n > 0 else -1]
