"""Tests of what a tab may send: nothing hostile reaches viser, the arms or the terminal."""

import math
import time

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed

from scenarios.viewer.serving.tab_messages import read_message
from tests.scenarios.viewer.sessions import run_to, wait_until
from tests.scenarios.viewer.test_page import (  # noqa: F401
    buttons,
    click,
    drain,
    served,
    shared,
    tab,
    until_quiet,
)
from tests.slow import slow

NAN, INF = math.nan, math.inf
POSE = {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0)}
UPDATE = {"type": "GuiUpdateMessage", "uuid": "x"}
GIZMO = {"type": "TransformControlsUpdateMessage", "name": "/take_over"}
FAULTS = [
    *(UPDATE | {"updates": {"value": value}} for value in (NAN, INF, -INF, 1e308, None, [1])),
    *(UPDATE | {"updates": {name: "x"}} for name in ("update_cb", "removed", "label")),
    GIZMO | POSE | {"wxyz": (NAN, 0.0, 0.0, 1.0)},
    GIZMO | POSE | {"position": (0.0, INF, 0.0)},
    GIZMO | POSE | {"position": (0.0, 0.0)},
    GIZMO | POSE | {"position": "abc"},
    GIZMO | POSE | {"more": 1},
    {"type": "ShareUrlRequest"},
    {"type": "FileTransferStartUpload", "source_component_uuid": "x"},
    {"type": "CommandTriggerMessage", "uuid": "x" * 10_000},
    {"type": "NoSuchMessage"},
    {"type": 3},
    [],
]


@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_only_what_the_page_itself_sends_is_read(fault):
    assert read_message(msgspec.msgpack.encode(fault)) is None


@pytest.mark.parametrize(
    "sent", [b"", b"\x00 rubbish", "text", b"\x91" * 100_000, b"\xc1", b"\xdd"]
)
def test_what_is_no_message_is_not_read(sent):
    assert read_message(sent) is None


@pytest.mark.parametrize("fault", [FAULTS[0], FAULTS[6], FAULTS[9], {"type": "ShareUrlRequest"}])
def test_a_tab_that_sends_a_fault_is_disconnected_and_nothing_is_printed(served, capfd, fault):  # noqa: F811
    session, port = served
    with tab(port) as bad:
        bad.send(msgspec.msgpack.encode(fault))
        with pytest.raises(ConnectionClosed):
            drain(bad, 10.0)
    session.pace.go_on()
    run_to(session, session.watcher.status().time_s + 0.2)
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize(
    "pose",
    [
        POSE | {"wxyz": (0.0, 0.0, 0.0, 0.0)},
        slow(POSE | {"position": (0.0, 0.0, 1e200)}),
        slow(POSE | {"wxyz": (1e200, 0.0, 0.0, 0.0)}),
    ],
)
def test_a_gizmo_that_is_no_pose_in_reach_leads_nowhere(served, capfd, pose):  # noqa: F811
    session, port = served
    with tab(port) as socket:
        uuids = buttons(until_quiet(socket, 2.0, begins_within_s=30.0))
        click(socket, uuids["Take the left"])
        wait_until(lambda: session.inbox.guided is not None, within_s=30.0)
        goal = session.inbox.guided
        socket.send(msgspec.msgpack.encode(GIZMO | pose))
        time.sleep(0.5)
        session.pace.go_on()
        run_to(session, session.watcher.status().time_s + 0.3)
        assert (session.inbox.guided.T_world_goal == goal.T_world_goal).all()
        click(socket, uuids["Give it back"])
        wait_until(lambda: session.inbox.guided is None, within_s=30.0)
    assert session.watcher.status().result is None
    assert "Traceback" not in capfd.readouterr().err
