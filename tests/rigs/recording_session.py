"""A session that is recorded once for all tests that read recordings."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import tool0
from tool0.description.shapes import Box
from tool0.protocol.state import Snapshot


class Session(NamedTuple):
    path: Path
    snapshots: list[Snapshot]
    """In the order in which they were published, also those that are not recorded."""


def record_session(path: Path) -> Session:
    """Record motion, a gripper, objects that come and go, a stop, and a pause."""
    from tool0.protocol.recordings import StartRecording, StopRecording

    with tool0.bringup(realtime=False, scene="table_and_cubes") as robot:
        robot.run(0.1)
        simulation = robot.simulation
        subscription = simulation.subscribe(
            125.0,
            keep_all=True,
            with_arms=True,
            with_contacts=True,
            forces_period=0.032,
        )
        robot.channel.call(StartRecording(file=str(path)))
        robot.move_joints({"elbow_joint": 1.6}, speed=0.8)
        robot.run(0.5)
        robot.gripper.move(opening=0.02)
        robot.scene.add("box", Box(size=(0.1, 0.1, 0.1)), xyz=(0.5, 0.5, 0.5), mass=1)
        robot.run(0.5)
        robot.scene.remove("ball")
        robot.emergency_stop()
        robot.run(0.1)
        robot.emergency_stop(engaged=False)
        robot.run(0.1)
        robot.pause()
        robot.scene.place("box", (0.6, 0.5, 0.5))
        robot.step(5)
        robot.resume()
        robot.run(0.1)
        status = robot.channel.call(StopRecording())
        snapshots = subscription.pending()
    assert status.error is None
    return Session(path, snapshots)


def recorded(session: Session) -> list[Snapshot]:
    """Return the snapshots that belong in the file, in order.

    Those are the first of each instant at the default rate, and while time is held,
    those in which something else moved.
    """
    found: list[Snapshot] = []
    for item in session.snapshots:
        last = found[-1] if found else None
        if last is None:
            is_recorded = True
        elif item.tick == last.tick:
            is_recorded = item.is_paused and (
                item.scene is not last.scene or item.objects != last.objects
            )
        else:
            is_recorded = item.tick % 8 == 0 or item.is_paused
        if is_recorded:
            found.append(item)
    return found
