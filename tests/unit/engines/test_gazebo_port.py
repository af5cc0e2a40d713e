"""The port that gzserver gets."""

import socket

import pytest

from tool0.engines.gazebo import server


def test_a_port_that_is_taken_on_another_address_is_not_free(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with socket.create_server(("127.9.8.7", 0)) as taken:
        with socket.create_server(("", 0)) as probe:
            free = probe.getsockname()[1]
        monkeypatch.setattr(server, "_PORTS", (taken.getsockname()[1], free))
        assert {server._free_port() for _ in range(20)} == {free}
