"""Controllers, the emergency stop and the simulation's time, by a real browser."""

from decimal import ROUND_HALF_UP, Decimal

import pytest
from browser import Tab, eventually, time_passes

import tool0

ARM = "eff_joint_traj_controller"
GROUP = "joint_group_eff_controller"


def state(robot: tool0.Robot, name: str) -> str:
    return next(item.state for item in robot.controllers() if item.name == name)


def row(name: str, is_state: str) -> str:
    return f"[data-testid=controller-row-{name}][data-state={is_state}]"


def is_at_rest(robot: tool0.Robot) -> bool:
    return all(abs(v) < 1e-3 for v in robot.joint_state.velocity.values())


def test_a_controller_is_stopped_and_started(tab: Tab, robot: tool0.Robot) -> None:
    tab.drive()
    tab.get("tab-controllers").click()
    tab.see(row(ARM, "running"))
    tab.get(f"controller-stop-{ARM}").click()
    tab.see(row(ARM, "stopped"))
    assert state(robot, ARM) == "stopped"
    tab.get("tab-motion").click()
    tab.see("[data-testid=joint-slider-elbow_joint][disabled]")
    tab.get("tab-controllers").click()
    tab.get(f"controller-start-{ARM}").click()
    tab.see(row(ARM, "running"))
    assert state(robot, ARM) == "running"


def test_a_refused_start_says_why_and_offers_the_switch(
    tab: Tab, robot: tool0.Robot
) -> None:
    tab.drive()
    tab.get("tab-controllers").click()
    tab.get(f"controller-start-{GROUP}").click()
    tab.text(f"controller-refusal-{GROUP}", ARM)
    assert state(robot, ARM) == "running"
    assert state(robot, GROUP) != "running"
    tab.get(f"controller-switch-{GROUP}").click()
    tab.see(row(GROUP, "running"))
    tab.see(row(ARM, "stopped"))
    assert state(robot, GROUP) == "running"


@pytest.mark.parametrize("by", ["button", "Escape"])
def test_the_emergency_stop_stops_a_moving_arm(
    tab: Tab, robot: tool0.Robot, by: str
) -> None:
    tab.drive()
    tab.get("speed-scale").press("Home")  # 1 %: the pose zero is a minute away
    tab.get("pose-go-zero").click()
    start = robot.joint_state.position["elbow_joint"]
    eventually(
        lambda: robot.joint_state.position["elbow_joint"] < start - 0.05,
        "the arm is on its way",
    )
    if by == "button":
        tab.get("estop").click()
    else:
        tab.page.keyboard.press("Escape")
    tab.get("estop-banner").wait_for()
    assert robot.snapshot.is_stopped
    robot.emergency_stop(False)
    tab.get("estop-banner").wait_for(state="hidden")
    tab.page.set_viewport_size({"width": 390, "height": 844})
    tab.get("menu").click()
    tab.page.keyboard.press("Escape")
    tab.get("language-zh").wait_for(state="hidden")
    tab.get("estop-banner").wait_for()
    eventually(lambda: is_at_rest(robot), "the brakes hold")
    assert robot.joint_state.position["elbow_joint"] > 0.1  # short of the pose zero
    assert tab.get("enable-toggle").is_disabled()

    held = robot.joint_state.position["elbow_joint"]
    hold(tab, 1.5)
    tab.get("estop-banner").wait_for(state="hidden")
    assert not robot.snapshot.is_stopped
    time_passes(robot, 0.5)  # nothing moves on its own
    assert robot.joint_state.position["elbow_joint"] == pytest.approx(held, abs=0.02)


def hold(tab: Tab, duration: float) -> None:
    """Press the release of the emergency stop for ``duration`` [s]."""
    release = tab.get("estop-release")
    release.hover()
    tab.page.mouse.down()
    tab.page.wait_for_timeout(1000.0 * duration)
    tab.page.mouse.up()


@pytest.mark.parametrize("interval", [80, 250])
def test_a_double_click_engages_the_emergency_stop(
    tab: Tab, robot: tool0.Robot, interval: int
) -> None:
    for _ in range(2):
        tab.get("estop").dblclick(delay=interval // 2)
    tab.get("estop-banner").wait_for()
    hold(tab, 0.3)  # too short
    assert robot.snapshot.is_stopped
    assert tab.get("estop-banner").is_visible()


def test_a_held_key_engages_the_emergency_stop(tab: Tab, robot: tool0.Robot) -> None:
    tab.get("estop").focus()
    for _ in range(10):  # without a release: the later ones are repetitions
        tab.page.keyboard.down("Enter")
    tab.get("estop-banner").wait_for()
    tab.page.keyboard.up("Enter")
    for key in ("Escape", "Enter"):
        tab.page.keyboard.press(key)
    assert robot.snapshot.is_stopped

    # the release has its own control, held by a key here
    tab.get("estop-release").focus()
    tab.page.keyboard.press("Enter")
    assert robot.snapshot.is_stopped
    tab.page.keyboard.down("Enter")
    tab.get("estop-banner").wait_for(state="hidden")
    tab.page.keyboard.up("Enter")
    assert not robot.snapshot.is_stopped


def shown(time: float) -> str:
    """Return simulated time as the page writes it: it receives six digits."""
    received = Decimal(round(time, 6))
    return f"{received.quantize(Decimal('0.01'), ROUND_HALF_UP)} s"


def test_escape_stops_the_robot_while_a_list_is_open(
    tab: Tab, robot: tool0.Robot
) -> None:
    tab.get("sim-speed").click()
    tab.page.keyboard.press("Escape")
    tab.get("estop-banner").wait_for()
    assert robot.snapshot.is_stopped


def test_time_is_paused_stepped_resumed_and_reset(tab: Tab, robot: tool0.Robot) -> None:
    assert tab.get("sim-step").is_disabled()
    tab.get("sim-pause").click()
    tab.get("sim-resume").wait_for()
    assert robot.snapshot.is_paused
    paused = robot.time
    tab.text("sim-time", shown(paused))

    tab.get("sim-step-length").select_option("100")
    tab.get("sim-step").click()
    stepped = paused + 100 * robot.control_period
    eventually(lambda: robot.time > paused, "a step passes")
    tab.text("sim-time", shown(stepped))
    assert robot.time == pytest.approx(stepped)

    tab.get("sim-resume").click()
    eventually(lambda: robot.time > stepped + 0.2, "time passes again")
    before = robot.time
    tab.get("sim-reset").click()
    tab.confirm()
    eventually(lambda: robot.time < before, "time begins again")


def test_a_reset_ends_driving_and_says_so(tab: Tab, robot: tool0.Robot) -> None:
    tab.drive()
    tab.get("sim-reset").click()
    tab.confirm()
    tab.text("driving-state", "reset")
    assert not tab.get("enable-toggle").is_checked()
