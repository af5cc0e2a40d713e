"""What ``tool0 doctor`` says about the UR interface."""

from __future__ import annotations

import socket

import pytest
from ur_address import free_host

from tool0.cli import probes
from tool0.installation.machine import Machine
from tool0.ur import options as ur_options
from tool0.ur.options import UrOptions


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> str:
    options = UrOptions(host=free_host())
    monkeypatch.setattr(ur_options, "UrOptions", lambda: options)
    return options.host


def test_it_is_ready(host: str) -> None:
    (result,) = probes.ur(Machine())
    assert (result.what, result.state, result.remedy) == ("ur", "ready", "")
    assert result.found.endswith(f"the ports of a UR at {host} are free")


def test_ports_in_use_are_named(host: str) -> None:
    with socket.create_server((host, 30002)):
        (result,) = probes.ur(Machine())
    assert result.state == "ready"
    assert f"in use at {host}: 30002; choose" in result.found


def test_a_missing_parser_can_be_installed(
    host: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(probes, "python_package_version", lambda package: None)
    (result,) = probes.ur(Machine())
    assert result.state == "missing"
    assert result.remedy.endswith("-m pip install lark")
