"""A person jogs the tool with a gamepad, which comes and goes."""

import numpy as np
from browser import Tab, comes_to_rest, eventually, time_passes

import tool0

GAMEPAD = """() => {
    const buttons = Array.from({ length: 17 }, () => ({ value: 0, pressed: false }));
    const kind = { id: "Fake", index: 0, connected: true, mapping: "standard" };
    window.pad = { ...kind, axes: [0, 0, 0, 0], buttons };
    window.polls = 0;
    navigator.getGamepads = () => { window.polls += 1; return [window.pad]; };
    window.hide = (hidden) => {
        const property = { configurable: true, get: () => hidden };
        Object.defineProperty(document, "hidden", property);
        document.dispatchEvent(new Event("visibilitychange"));
    };
}"""
STILL = 1e-3
"""Of a held arm [m]."""


class Person:
    """Holds a gamepad in front of a page on which *Drive* is on."""

    def __init__(self, tab: Tab, robot: tool0.Robot) -> None:
        self.tab, self.robot = tab, robot
        tab.page.evaluate(GAMEPAD)
        tab.drive()
        tab.get("tool-toggle").click()
        tab.get("jog-gamepad").click()
        tab.text("jog-gamepad-name", "Fake")
        comes_to_rest(robot)

    def does(self, script: str) -> None:
        self.tab.page.evaluate(script)

    def pushes(self, share: float = -1.0) -> None:
        """Push the left stick to the left, along y."""
        self.does(f"window.pad.axes[0] = {share}")

    def holds_the_shoulder_button(self, is_held: bool = True) -> None:
        self.holds(4, is_held)

    def holds(self, button: int, is_held: bool = True) -> None:
        self.does(f"window.pad.buttons[{button}].value = {int(is_held)}")

    def is_looked_at(self) -> None:
        """Wait until the page has read the gamepad as it is now."""
        after = int(self.tab.page.evaluate("window.polls")) + 1
        eventually(
            lambda: int(self.tab.page.evaluate("window.polls")) > after,
            "the page reads the gamepad",
        )

    def y(self) -> float:
        return float(self.robot.arm.pose().position[1])

    def sees_it_move(self) -> None:
        start = self.y()
        eventually(lambda: self.y() - start > 0.005, "tool0 moves along y")

    def sees_it_rest(self) -> None:
        """Wait until the page has given the arm back, and see it hold its pose."""
        box = self.robot.arm.control_box
        eventually(lambda: not box.state.taken_by, "the arm is released")
        comes_to_rest(self.robot)
        before = np.array(self.robot.arm.pose().position)
        self.is_looked_at()
        time_passes(self.robot, 0.2)
        assert not box.state.taken_by
        assert np.abs(self.robot.arm.pose().position - before).max() < STILL

    def pushes_anew(self) -> None:
        """Only a stick that was in the middle moves the tool."""
        self.sees_it_rest()
        self.pushes(0.0)
        self.is_looked_at()
        self.pushes()
        self.sees_it_move()


def test_a_gamepad_jogs_while_its_shoulder_button_is_held(
    tab: Tab, robot: tool0.Robot
) -> None:
    person = Person(tab, robot)
    person.pushes()
    time_passes(robot, 0.2)
    assert robot.arm.control_box.state.taken_by == ""
    person.holds_the_shoulder_button()
    person.sees_it_move()
    person.holds_the_shoulder_button(False)
    person.sees_it_rest()


def test_after_an_interruption_only_a_fresh_push_of_a_gamepad_moves(
    tab: Tab, robot: tool0.Robot
) -> None:
    person = Person(tab, robot)
    person.holds_the_shoulder_button()
    person.pushes()
    person.sees_it_move()

    person.does("window.pad.connected = false")  # it is unplugged
    tab.text("jog-gamepad-name", "No gamepad")
    person.sees_it_rest()
    person.does("window.pad.connected = true")
    tab.text("jog-gamepad-name", "Fake")
    person.pushes_anew()

    person.does("window.hide(true)")
    person.sees_it_rest()
    person.does("window.hide(false)")
    person.pushes_anew()

    person.does("window.dispatchEvent(new Event('blur'))")
    person.pushes_anew()
    person.holds_the_shoulder_button(False)
    person.sees_it_rest()


def test_buttons_of_a_gamepad_close_and_open_the_gripper(
    tab: Tab, robot: tool0.Robot
) -> None:
    close, open_ = 0, 1
    person = Person(tab, robot)
    person.holds(close)
    person.is_looked_at()
    person.holds(close, False)
    person.is_looked_at()
    person.holds_the_shoulder_button()
    person.is_looked_at()
    assert robot.gripper.opening > 0.08
    person.holds(close)
    eventually(lambda: robot.gripper.opening < 0.005, "it closes")
    person.holds(open_)
    eventually(lambda: robot.gripper.opening > 0.08, "it opens")
