"""Programs that a person teaches, edits and runs in a real browser."""

from collections.abc import Iterator
from math import pi

import numpy as np
import pytest
from browser import Tab, comes_to_rest, eventually

import tool0
from conftest import OpenTab
from tool0.api.table import BIN, ITEM
from tool0.panel.server import Panel
from tool0.protocol.program import LoopStep, MoveJointStep
from tool0.protocol.programs import ENDED, ReadRuns
from tool0.scene import Pose

SPEED = 20.0
"""Simulated seconds per wall second, if the machine is fast enough."""
BETWEEN_PADS = Pose(xyz=(0.0, 0.0, 0.1418))
"""In tool0, with the pads 45 mm apart [m]."""


@pytest.fixture(scope="module")
def cell() -> Iterator[tool0.Robot]:
    with tool0.bringup(scene="table_and_bin", speed=SPEED) as robot:
        yield robot


@pytest.fixture(scope="module")
def address(cell: tool0.Robot) -> Iterator[str]:
    with Panel(cell) as panel:
        yield panel.url


@pytest.fixture
def tab(address: str, cell: tool0.Robot, open_tab: OpenTab) -> Tab:
    cell.reset()
    tab = open_tab(address)
    tab.page.set_viewport_size({"width": 1100, "height": 700})
    tab.get("tab-program").click()
    tab.get("program-add-wait").wait_for()
    return tab


def drive(tab: Tab) -> None:
    """Switch *Drive* on; a robot that another client moves switches it off."""
    tab.get("enable-toggle").click()
    tab.see("[data-testid=program-run]:not([disabled])")


def fill(tab: Tab, test_id: str, text: str) -> None:
    """Type a value into a field."""
    field = tab.get(test_id)
    field.fill(text)
    field.press("Enter")


def steps(tab: Tab) -> list[str]:
    """Return the paths of the steps that the page lists, in order."""
    return tab.page.locator("[data-testid=program-steps] [data-path]").evaluate_all(
        "rows => rows.map(row => row.dataset.path)"
    )


def is_in_bin(robot: tool0.Robot) -> bool:
    """Return whether the cube lies in the bin."""
    floor = robot.scene.pose(f"{BIN}.floor").position
    way = np.subtract(robot.scene.pose(ITEM).position, floor)
    return bool(np.all(np.abs(way[:2]) < 0.09) and way[2] < 0.06)


def has_ended(robot: tool0.Robot, number: int) -> bool:
    """Return whether a run of a program has ended; a page may miss a short one."""
    runs = robot.channel.call(ReadRuns())
    return any(run.run == number and run.state in ENDED for run in runs)


def runs_from_its_start(tab: Tab) -> None:
    """Hold the button until the arm is where the program begins, and run it there."""
    tab.get("program-run").click()
    tab.get("program-approach").hover()
    tab.page.mouse.down()
    tab.get("program-away").wait_for(state="hidden")
    tab.page.mouse.up()
    tab.get("program-run").click()


def ends(tab: Tab) -> None:
    """Wait until the program has ended well."""
    tab.see("[data-testid=program-stop][disabled]")
    error = tab.get("program-error")
    assert error.count() == 0, error.text_content()
    tab.text("program-state", "Done")


class Teacher:
    """Moves the arm to where a person would, and adds waypoints in the page."""

    def __init__(self, tab: Tab, robot: tool0.Robot) -> None:
        self._tab, self._robot = tab, robot

    def waypoint(self, x: float, y: float, z: float) -> None:
        """Add a move to where the pads are around a place [m]."""
        pose = Pose(xyz=(x, y, z), rpy=(pi, 0.0, 0.0))
        self._robot.arm.move_to(pose, tool=BETWEEN_PADS, speed=1.0).wait()
        self.teach()

    def teach(self) -> None:
        """Add a move to where the arm is, once the page shows that."""
        self._tab.page.wait_for_function(
            "time => Number(document.querySelector('[data-testid=sim-time]')"
            ".textContent.replace(/[^0-9.]/g, '')) > time",
            arg=self._robot.time + 0.2,
        )
        self._tab.get("program-add-move_joint").click()
        fill(self._tab, "step-speed", "3")
        fill(self._tab, "step-acceleration", "8")


def test_a_taught_pick_with_ten_waypoints_succeeds_every_time(
    tab: Tab, cell: tool0.Robot
) -> None:
    x, y, z = cell.scene.pose(ITEM).position
    bin_x, bin_y, _ = cell.scene.pose(f"{BIN}.floor").position
    teacher = Teacher(tab, cell)
    tab.get("program-add-place_object").click()
    assert tab.get("step-object").input_value() == ITEM
    tab.get("program-add-gripper").click()
    tab.get("step-opening").select_option("open")
    teacher.teach()
    teacher.waypoint(x, y, z + 0.20)
    teacher.waypoint(x, y, z + 0.10)
    teacher.waypoint(x, y, z)
    tab.get("program-add-gripper").click()
    tab.get("step-must-hold").click()
    teacher.waypoint(x, y, z + 0.15)
    teacher.waypoint(0.5 * (x + bin_x), 0.5 * (y + bin_y), z + 0.25)
    teacher.waypoint(bin_x, bin_y, z + 0.20)
    teacher.waypoint(bin_x, bin_y, z + 0.12)
    tab.get("program-add-gripper").click()
    tab.get("step-opening").select_option("open")
    teacher.waypoint(bin_x, bin_y, z + 0.20)
    teacher.waypoint(x, y, z + 0.20)
    tab.get("program-check").click()
    tab.get("program-fine").wait_for()
    drive(tab)
    before = max((run.run for run in cell.channel.call(ReadRuns())), default=0)
    for number in range(before + 1, before + 4):
        runs_from_its_start(tab)
        eventually(lambda n=number: has_ended(cell, n), f"run {number} has ended")
        ends(tab)
        assert is_in_bin(cell)


class Keyboard:
    """The page without a mouse."""

    def __init__(self, tab: Tab) -> None:
        self._tab, self._press = tab, tab.page.keyboard.press

    def go(self, test_id: str) -> None:
        """Press Tab until an element has the focus."""
        for _ in range(150):
            focused = self._tab.page.evaluate(
                "document.activeElement?.getAttribute('data-testid')"
            )
            if focused == test_id:
                return
            self._press("Tab")
        raise AssertionError(f"the Tab key does not reach {test_id}")

    def use(self, test_id: str, *keys: str) -> None:
        """Go to an element and press keys there."""
        self.go(test_id)
        for key in keys:
            self._press(key)

    def enter(self, test_id: str, text: str) -> None:
        """Go to a field, type into it, and press Enter."""
        self.go(test_id)
        self._press("Control+a")
        self._tab.page.keyboard.type(text)
        self._press("Enter")


def test_a_program_is_taught_saved_and_run_by_keyboard_alone(
    tab: Tab, cell: tool0.Robot
) -> None:
    keys = Keyboard(tab)
    keys.use("enable-toggle", "Space")
    keys.use("program-add-move_joint", "Enter")
    keys.enter("step-joint-wrist_3_joint", "0.4")
    keys.enter("step-speed", "2")
    keys.use("program-add-gripper", "Enter")
    keys.use("program-add-wait", "Enter")
    keys.enter("step-duration", "0.1")
    assert steps(tab) == ["1", "2", "3"]
    keys.use("program-step-3", "ArrowUp", "ArrowUp")  # the move
    keys.use("program-step-1", "Control+d")
    keys.enter("step-joint-wrist_3_joint", "-0.3")
    keys.use("program-step-2", "Alt+ArrowDown", "Alt+ArrowDown", "Delete", "Control+z")
    tab.get("program-step-4").wait_for()
    keys.use("program-add-loop", "Enter")
    keys.use("program-step-5", "Alt+ArrowUp")  # before the second move
    keys.use("program-step-4", "ArrowDown", "Alt+ArrowRight")
    assert steps(tab) == ["1", "2", "3", "4", "4.1"]
    keys.enter("program-name", "wave")
    keys.go("program-check")
    keys.use("program-check", "Enter")
    tab.get("program-fine").wait_for()
    keys.use("program-run", "Enter")
    tab.get("program-away").wait_for()
    keys.go("program-approach")
    tab.page.keyboard.down(" ")
    tab.get("program-away").wait_for(state="hidden")
    tab.page.keyboard.up(" ")
    keys.use("program-run", "Enter")
    tab.text("program-now", "wave")
    ends(tab)
    assert cell.joint_state.position["wrist_3_joint"] == pytest.approx(-0.3, abs=0.01)
    assert cell.gripper.opening < 0.01
    eventually(
        lambda: [saved.name for saved in cell.programs.list()] == ["wave"],
        "it is saved",
    )
    first, *_, loop = cell.programs.read("wave").steps
    assert isinstance(first, MoveJointStep)
    assert first.joints is not None
    assert first.joints["wrist_3_joint"] == pytest.approx(0.4)
    assert isinstance(loop, LoopStep)
    assert [type(step) for step in loop.steps] == [MoveJointStep]


def test_steps_are_dragged_and_a_wrong_one_is_named(tab: Tab) -> None:
    for kind in ("comment", "wait", "loop"):
        tab.get(f"program-add-{kind}").click()
    grip = tab.get("program-step-1").locator(".grip").bounding_box()
    loop = tab.get("program-step-3").bounding_box()
    assert grip is not None
    assert loop is not None
    tab.page.mouse.move(grip["x"] + 8, grip["y"] + 8)
    tab.page.mouse.down()
    tab.page.mouse.move(grip["x"] + 8, loop["y"] + loop["height"] * 0.8, steps=5)
    tab.page.mouse.up()
    assert steps(tab) == ["1", "2", "2.1"]
    tab.text("program-step-2.1", "Comment")
    tab.get("program-undo").click()
    assert steps(tab) == ["1", "2", "3"]
    tab.get("program-step-3").click()
    tab.get("program-delete").click()
    tab.get("program-add-move_linear").click()
    tab.get("step-target").select_option("pose")
    fill(tab, "step-pose-position-0", "3000")
    tab.get("program-check").click()
    tab.text("program-problem", "Step 3")
    tab.get("program-remark-3").wait_for()


def test_the_way_to_the_start_ends_with_the_press(tab: Tab, cell: tool0.Robot) -> None:
    tab.get("program-add-move_joint").click()
    fill(tab, "step-label", "above cube")
    fill(tab, "step-joint-wrist_3_joint", "3")
    tab.text("program-step-1", "above cube")
    drive(tab)
    cell.set_speed(1.0)
    tab.get("program-run").click()
    tab.get("program-approach").hover()
    tab.page.mouse.down()
    eventually(
        lambda: cell.joint_state.velocity["wrist_3_joint"] > 0.1,
        "the arm moves to the start",
    )
    tab.page.mouse.up()
    comes_to_rest(cell)
    assert cell.joint_state.position["wrist_3_joint"] < 2.5
    cell.set_speed(SPEED)
    number = 1 + max((run.run for run in cell.channel.call(ReadRuns())), default=0)
    tab.get("program-run-here").click()
    eventually(lambda: has_ended(cell, number), "the program has ended")
    ends(tab)
    assert cell.joint_state.position["wrist_3_joint"] == pytest.approx(3.0, abs=0.01)
