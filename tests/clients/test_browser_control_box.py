"""The control box in the panel, by a real browser and a real robot."""

from browser import Tab, eventually

import tool0
from tool0.protocol.control_box_state import RobotMode, SafetyMode


def test_an_arm_is_stopped_unlocked_and_played(tab: Tab, robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    tab.drive()
    tab.get("tab-io").click()
    tab.text("safety-mode", "Normal")
    box.stop_protectively("somebody is near")
    tab.text("protective-stop-banner", "somebody is near")
    tab.text("program-state", "Stopped")
    tab.get("unlock-arm").click()  # too soon
    tab.see(".toast").filter(has_text="Cannot unlock").first.wait_for()
    robot.reset()  # the 5 s are of simulated time
    tab.get("unlock-arm").click()
    tab.get("protective-stop-banner").wait_for(state="detached")
    assert box.state.safety_mode is SafetyMode.NORMAL
    tab.get("enable-toggle").click()  # the reset has switched it off
    tab.get("program-play").click()
    tab.text("program-state", "Playing")
    tab.get("power-off").click()
    tab.text("robot-mode", "Powered off")
    tab.get("power-on").press("Enter")
    tab.text("robot-mode", "Idle")
    tab.get("release-brakes").press(" ")
    tab.text("robot-mode", "Running")
    assert box.state.robot_mode is RobotMode.RUNNING


def test_inputs_are_set_and_outputs_are_shown(tab: Tab, robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    tab.get("tab-io").click()
    assert tab.get("pin-inputs-9").is_disabled()  # read-only
    tab.get("enable-toggle").click()
    tab.get("pin-inputs-9").press(" ")
    tab.see("[data-testid=pin-inputs-9][aria-checked=true]")
    assert box.state.digital_inputs[9]
    box.set_digital_output(2, True)
    tab.see("[data-testid=pin-outputs-2][data-level=true]")
    field = tab.get("analog-input-0")
    field.fill("3.3")
    field.press("Enter")
    eventually(lambda: box.state.analog_inputs[0].value == 3.3, "the input is set")
    tab.get("box-speed").press("PageDown")
    eventually(lambda: box.state.speed_slider == 0.9, "the slider is at 90 %")
