"""Options of the UR interface, and of the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tool0.cli.options import BringupOptions, RunOptions, UrControllerOptions
from tool0.errors import ConfigError
from tool0.ur.options import MAX_PORT_BASE, UrOptions


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"host": "localhost"}, "IPv4 address"),
        ({"host": "::1"}, "IPv4 address"),
        ({"host": "127.0.0.256"}, "IPv4 address"),
        ({"port_base": -1}, "in \\[0, 2183\\]"),
        ({"port_base": MAX_PORT_BASE + 1}, "in \\[0, 2183\\]"),
        ({"programs": Path("/no/such/folder")}, "not a folder"),
    ],
    ids=str,
)
def test_a_wrong_option_is_refused(wrong: dict[str, object], reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        UrOptions(**wrong)  # type: ignore[arg-type]


def test_each_arm_has_an_address() -> None:
    options = UrOptions(host="127.0.0.254")
    assert [options.host_of(k) for k in range(3)] == [
        *("127.0.0.254", "127.0.0.255", "127.0.1.0"),
    ]
    everywhere = UrOptions(host="0.0.0.0")
    assert everywhere.is_public
    assert not options.is_public
    assert everywhere.host_of(0) == "0.0.0.0"
    with pytest.raises(ConfigError, match="several arms"):
        everywhere.host_of(1)


def test_options_of_the_controller_need_the_controller() -> None:
    with pytest.raises(ConfigError, match="need --ur"):
        BringupOptions(ur=UrControllerOptions(ur_port_base=1000))
    with pytest.raises(ConfigError, match="--no-remote"):
        RunOptions(ur=True, remote=False)


def test_it_goes_together_with_ros(tmp_path: Path) -> None:
    given = UrControllerOptions(
        ur_host="127.0.0.5", ur_sockets=True, ur_programs=tmp_path
    )
    for run in (RunOptions(ur=True, ros1=True), RunOptions(ur=True, ros2=True)):
        options = BringupOptions(run=run, ur=given).ur.options()
        assert options == UrOptions(
            host="127.0.0.5", allow_sockets=True, programs=tmp_path
        )
