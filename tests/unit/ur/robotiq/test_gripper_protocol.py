"""A gripper that does not name Robotiq's protocol has none of its interfaces."""

from __future__ import annotations

import asyncio
import logging
import shutil
from pathlib import Path

import pytest
from ur_box_rig import control_box
from urscript_rig import run_on

import tool0
from tool0.description.catalogue import find_part
from tool0.ur.options import UrOptions
from tool0.ur.robotiq.interface import RobotiqInterface
from tool0.ur.service import interfaces_of

MESSAGE = "the arm's gripper speaks no protocol that tool0 has (there is robotiq)"


@pytest.fixture
def jaws(tmp_path: Path) -> Path:
    """Return a copy of a gripper's folder, as for one of another make."""
    built_in = find_part("gripper", "2f85").folder
    folder = Path(shutil.copytree(built_in, tmp_path / "jaws"))
    file = folder / "joint_limits.yaml"
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    others = [line for line in lines if not line.lstrip().startswith("protocol:")]
    assert len(others) == len(lines) - 1
    file.write_text("".join(others), encoding="utf-8")
    return folder


@pytest.mark.slow
def test_a_folder_that_names_no_protocol_has_no_ports_and_functions(
    jaws: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async def look(robot: tool0.Robot) -> str:
        async with control_box(robot) as box:
            assert box.gripper is None
            found = interfaces_of(box, UrOptions(active_gripper=True))
            assert not any(isinstance(item, RobotiqInterface) for item in found)
            return str((await run_on(box, "rq_open()")).error)

    with tool0.bringup(gripper=str(jaws), realtime=True) as robot:
        with caplog.at_level(logging.WARNING):
            error = asyncio.run(look(robot))
        assert robot.gripper.move(opening=0.02).wait(10.0)  # as always
        grip = tool0.Program(name="grip", steps=(tool0.GripperStep(opening="open"),))
        with pytest.raises(tool0.ProgramError, match=r"step 1: .* Robotiq grippers"):
            robot.programs.export(grip, "urscript")
    assert f"rq_open: {MESSAGE}" in error
    assert MESSAGE in caplog.text
