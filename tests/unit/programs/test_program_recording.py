"""A recorded program can be repeated: everything it did is in the journal."""

from __future__ import annotations

from pathlib import Path

import pytest
from taught_programs import taught_pick

import tool0


@pytest.mark.slow
def test_a_recorded_program_is_repeated_to_the_bit(tmp_path: Path) -> None:
    from tool0.protocol.recordings import StartRecording, StopRecording
    from tool0.recording.resimulation import resimulate

    with tool0.bringup(arm="ur5e", scene="table_and_bin", realtime=False) as robot:
        robot.channel.call(StartRecording(file=str(tmp_path / "pick.mcap")))
        steps = (
            *taught_pick(robot).steps[:7],
            tool0.UntilStep(direction=(0.0, 0.0, -1.0), distance=0.2, speed=0.1),
            tool0.GripperStep(opening="open"),
        )
        program = robot.run_program(tool0.Program(name="place", steps=steps))
        robot.run(1.0)
        program.pause()
        robot.run(0.3)
        program.resume()
        assert program.wait(60.0).state == "succeeded"
        goal = robot.move_joints({"elbow_joint": 1.2})[0]
        robot.run(0.1)
        goal.cancel()  # goals have the numbers that they had
        robot.run(0.1)
        robot.channel.call(StopRecording())
    (file,) = tmp_path.glob("*.mcap")
    found = resimulate(tool0.open_recording(file))
    assert found.divergence is None
    assert found.is_identical
    assert found.frames > 100
