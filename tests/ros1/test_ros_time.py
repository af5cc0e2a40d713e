"""Simulated time in ROS, changing hands while it runs."""

from __future__ import annotations

import threading

import pytest
from tool0.interfaces.ros1.ros_time import RosTime


@pytest.mark.usefixtures("rospy")
def test_a_clock_changes_hands_while_it_is_told() -> None:
    time = RosTime(is_ours=True)
    over, errors = threading.Event(), []

    def tell() -> None:
        now = 0.0
        while not over.is_set():
            now += 0.001
            try:
                time.advance(now)
            except Exception as error:
                errors.append(error)

    teller = threading.Thread(target=tell)
    teller.start()
    for _ in range(20):
        time.give_up()
        assert not time.is_ours
        time.take_over()
        assert time.is_ours
    over.set()
    teller.join()
    time.give_up()
    assert errors == []
