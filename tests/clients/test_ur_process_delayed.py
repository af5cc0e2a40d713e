"""A process of the UR interface that was delayed."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from itertools import pairwise

import pytest
from processes import process_of
from ros import Bringup
from rtde_rig import RtdeClient
from ur_address import free_host
from waits import until

import tool0
from tool0.ur.process import MODULE


def test_no_state_is_left_out_after_the_process_did_not_run_for_a_while() -> None:
    host = free_host()
    with (
        closing(
            Bringup(os.environ, "--ur", "--arm", "ur5e", "--ur-host", host)
        ) as bringup,
        pytest.MonkeyPatch.context() as patch,
    ):
        bringup.wait()
        patch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
        process = process_of(MODULE, bringup.process.pid)
        assert process is not None
        with tool0.connect() as robot, closing(RtdeClient(host)) as client:
            client.receive(["timestamp"])
            client.start()
            (first,) = client.sample()
            for _ in range(3):
                start = robot.time
                os.kill(process, signal.SIGSTOP)
                until(lambda start=start: robot.time > start + 0.3, "the robot's time")
                os.kill(process, signal.SIGCONT)
                last = robot.time
                times = [first]
                while times[-1] < last:
                    times += client.sample()
                steps = {round(1e3 * (b - a)) for a, b in pairwise(times)}
                assert steps <= {2, 0}  # while it waits, the last one is repeated
                first = times[-1]
