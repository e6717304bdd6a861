"""The allowed messages of a tab of the page: a few kinds, finite and of the right form.

Without this check viser sets any property that a tab names, and shares the page with the world on
request. It also keeps uploads, and ends in a traceback at invalid messages. A tab that sends any
other message is therefore disconnected before viser receives the message. The browser then connects
again, and shows the true state.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import msgspec
import viser
from msgspec import Meta

Number = Annotated[float, Meta(ge=-1e300, le=1e300)]  # neither infinite nor not-a-number
Name = Annotated[str, Meta(max_length=200)]
Point = tuple[Number, Number, Number]
Turn = tuple[Number, Number, Number, Number]


class _Kind(msgspec.Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """A message whose name is in its field `type`; other fields than its own are refused."""


class GuiUpdateMessage(_Kind):
    uuid: Name
    updates: dict[Literal["value"], bool | Number | str]


class GuiFormSubmitMessage(_Kind):
    uuid: Name


class GuiFormDirtyMessage(_Kind):
    uuid: Name


class GuiButtonHoldMessage(_Kind):
    uuid: Name
    frequency: Number


class CommandTriggerMessage(_Kind):
    uuid: Name


class TransformControlsUpdateMessage(_Kind):
    name: Name
    wxyz: Turn
    position: Point
    owner: Name = ""


class TransformControlsDragStartMessage(_Kind):
    name: Name
    owner: Name = ""


class TransformControlsDragEndMessage(_Kind):
    name: Name
    owner: Name = ""


class ViewerCameraMessage(_Kind):
    """The tab's viewpoint, which only that tab uses: any number."""

    wxyz: tuple[float, float, float, float]
    position: tuple[float, float, float]
    fov: float
    near: float
    far: float
    image_height: float
    image_width: float
    look_at: tuple[float, float, float]
    up_direction: tuple[float, float, float]


TabMessage = (
    GuiUpdateMessage
    | GuiFormSubmitMessage
    | GuiFormDirtyMessage
    | GuiButtonHoldMessage
    | CommandTriggerMessage
    | TransformControlsUpdateMessage
    | TransformControlsDragStartMessage
    | TransformControlsDragEndMessage
    | ViewerCameraMessage
)
_DECODER = msgspec.msgpack.Decoder(TabMessage)


def is_allowed(sent: str | bytes, widgets: Mapping[str, Any]) -> bool:
    """Return whether the page itself could have sent this, with these widgets by their uuid."""
    message = read_message(sent)
    if not isinstance(message, GuiUpdateMessage) or message.uuid not in widgets:
        return message is not None
    widget = widgets[message.uuid]
    return all(_fits(widget, value) for value in message.updates.values())


def _fits(widget: Any, value: bool | float | str) -> bool:
    if isinstance(widget, viser.GuiDropdownHandle):
        return value in widget.options
    kind = next((k for k in (bool, str) if isinstance(widget.value, k)), float)
    return isinstance(value, kind)


def read_message(sent: str | bytes) -> TabMessage | None:
    """Return the message that a tab sent; None if the page sends no such message."""
    try:
        return _DECODER.decode(sent.encode() if isinstance(sent, str) else sent)
    except (msgspec.MsgspecError, RecursionError, UnicodeError):
        return None
