"""The ROS 2 node's requests are those of the contract."""

from __future__ import annotations

import ast
import re

import msgspec
from tool0_ros2 import requests
from tools.ros2_requests import MODULE, NODE, REQUESTS, module_text

from tool0.protocol.codec import decode_request
from tool0.protocol.motion import CommandGripper
from tool0.protocol.request import method_name

SOURCES = {path: path.read_text("utf-8") for path in NODE.glob("*.py")}
HAND_WRITTEN = [text for path, text in SOURCES.items() if path != MODULE]
METHODS = {method_name(kind) for kind in REQUESTS}


def test_the_node_s_requests_are_made_from_the_contract_as_it_is() -> None:
    assert SOURCES[MODULE] == module_text(), (
        "the contract has changed; run `python -m tools.ros2_requests`"
    )


def test_what_is_left_out_has_the_default_of_the_contract() -> None:
    request = requests.command_gripper(controller="gripper", position=0.5)
    assert request.params == {"controller": "gripper", "position": 0.5}
    _, decoded = decode_request(msgspec.json.encode({"id": 1, **vars(request)}))
    assert decoded == CommandGripper(controller="gripper", position=0.5)


def test_no_other_module_of_the_node_writes_the_name_of_a_request() -> None:
    for text in HAND_WRITTEN:
        assert not re.search(r"\.(call|submit|post)\(\s*[\"']", text)
        assert not re.search(r"\bRequest\(", text)


def test_the_node_sends_each_of_them() -> None:
    sent = {
        name
        for text in HAND_WRITTEN
        for node in ast.walk(ast.parse(text))
        for name in [getattr(node, "attr", getattr(node, "id", None))]
    }
    assert METHODS - sent == set()
