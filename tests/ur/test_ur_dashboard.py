"""The dashboard server against UR's documents, and ur_rtde's client."""

from __future__ import annotations

import socket

import pytest
from ur_rig import ur_rig

from tool0.protocol.control_box import StopProtectively

NO_PROGRAM = "STOPPED <unnamed>"
TOO_SOON = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of "
    "protective stop before unlocking"
)
WAITING = """def waiting():
  while True:
    set_standard_digital_out(3, True)
    sync()
  end
end
"""


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    folder = tmp_path_factory.mktemp("programs")
    (folder / "waiting.script").write_text(WAITING)
    (folder / "wrong.script").write_text("def wrong():\n  movej(\nend\n")
    with ur_rig(folder, speed=10.0) as rig:
        yield rig


@pytest.fixture
def dashboard(rig):
    dashboard = rig.dashboard()
    yield dashboard
    dashboard.ask("stop")
    dashboard.close()


@pytest.fixture
def external(dashboard):
    """The URCap's program, loaded."""
    name = "external_control.urp"
    assert dashboard.ask(f"load {name}") == f"Loading program: {name}"
    return dashboard


def test_it_greets_and_ends(rig):
    dashboard = rig.dashboard()
    assert dashboard.greeting == "Connected: Universal Robots Dashboard Server"
    assert dashboard.ask("quit") == "Disconnected"
    assert dashboard.read() == ""
    dashboard.close()


@pytest.mark.parametrize(
    ("command", "answer"),
    [
        ("PolyscopeVersion", "URSoftware 5.25.1.0 (tool0)"),
        ("polyscopeversion", "URSoftware 5.25.1.0 (tool0)"),
        ("version", "5.25.1.0"),
        ("get robot model", "UR5"),
        ("is in remote control", "true"),
        ("running", "Program running: false"),
        ("RobotMode", "Robotmode: RUNNING"),
        ("safetymode", "Safetymode: NORMAL"),
        ("SAFETYSTATUS", "Safetystatus: NORMAL"),
        ("get loaded program", "No program loaded"),
        ("isProgramSaved", "false <unnamed>"),
        ("programState", NO_PROGRAM),
        ("play", "Failed to execute: play"),
        ("pause", "Failed to execute: pause"),
        ("stop", "Stopped"),
        ("load absent.urp", "File not found: absent.urp"),
        (
            "load installation default.installation",
            "Loading installation: default.installation",
        ),
        ("load installation cell.installation", "File not found: cell.installation"),
        ("popup Hello,  you", "showing popup"),
        ("close popup", "closing popup"),
        ("close safety popup", "closing safety popup"),
        ("addToLog Cell 7 is ready", "Added log message"),
        ("addToLog", "No log message to add"),
        ("get operational mode", "NONE"),
        ("set operational mode manual", "Operational mode 'MANUAL' is set"),
        ("set operational mode fast", "Failed setting operational mode: fast"),
        (
            "clear operational mode",
            "No longer controlling the operational mode. Current operational mode: "
            "'MANUAL'.",
        ),
        ("unlock protective stop", "Protective stop releasing"),
        (
            "generate flight report system",
            "Error: a simulated robot has no reports to save",
        ),
        ("dance", "could not understand: 'dance'"),
        ("playing", "could not understand: 'playing'"),
        ("setUserRole none", "could not understand: 'setUserRole none'"),
        ("", "could not understand: ''"),
    ],
)
def test_answers_are_those_of_the_documents(dashboard, command, answer):
    assert dashboard.ask(command) == answer


def test_the_log_is_saved(rig, dashboard):
    assert dashboard.ask("addToLog Cell 8 is ready") == "Added log message"
    assert dashboard.ask("popup Hello") == "showing popup"
    assert dashboard.ask("saveLog") == "Log saved to disk"
    lines = (rig.programs / "log_history.txt").read_text().splitlines()
    assert lines[-2].endswith(" note: Cell 8 is ready")
    assert lines[-1].endswith(" popup: Message Hello")


def test_a_serial_number_is_a_number(dashboard):
    number = dashboard.ask("get serial number")
    assert number.isdigit()
    assert number.startswith("20")


def test_power_off_and_on(rig, dashboard):
    assert dashboard.ask("power off") == "Powering off"
    dashboard.until("robotmode", "Robotmode: POWER_OFF")
    assert dashboard.ask("play") == "Failed to execute: play"
    assert dashboard.ask("power on") == "Powering on"
    dashboard.until("robotmode", "Robotmode: IDLE")
    assert dashboard.ask("brake release") == "Brake releasing"
    dashboard.until("robotmode", "Robotmode: RUNNING")
    dashboard.ask("power off")
    assert dashboard.ask("brake release") == "Brake releasing", "powers on as well"
    dashboard.until("robotmode", "Robotmode: RUNNING")


def test_a_protective_stop_is_unlocked_after_five_seconds(rig, dashboard):
    load_and_play(dashboard)
    rig.robot.channel.call(StopProtectively(reason="a test"))
    dashboard.until("safetymode", "Safetymode: PROTECTIVE_STOP")
    assert dashboard.ask("safetystatus") == "Safetystatus: PROTECTIVE_STOP"
    assert dashboard.ask("robotmode") == "Robotmode: RUNNING"
    dashboard.until("programState", "STOPPED waiting.urp")
    assert dashboard.ask("play") == "Failed to execute: play"
    assert dashboard.ask("unlock protective stop") == TOO_SOON
    dashboard.until("unlock protective stop", "Protective stop releasing")
    dashboard.until("safetymode", "Safetymode: NORMAL")
    assert dashboard.ask("running") == "Program running: false", "nothing moves yet"
    assert dashboard.ask("play") == "Starting program"


def test_an_emergency_stop_shows_and_blocks(rig, dashboard):
    rig.robot.emergency_stop()
    dashboard.until("safetymode", "Safetymode: ROBOT_EMERGENCY_STOP")
    assert dashboard.ask("robotmode") == "Robotmode: POWER_OFF"
    assert dashboard.ask("power on") == "Failed to execute: power on"
    assert dashboard.ask("play") == "Failed to execute: play"
    rig.robot.emergency_stop(engaged=False)
    dashboard.until("safetymode", "Safetymode: NORMAL")


def load_and_play(dashboard):
    assert dashboard.ask("load waiting.urp") == "Loading program: waiting.urp"
    assert dashboard.ask("play") == "Starting program"


def test_a_program_is_loaded_played_paused_and_stopped(rig, dashboard):
    load_and_play(dashboard)
    assert dashboard.ask("get loaded program") == "Loaded program: waiting.urp"
    assert dashboard.ask("isProgramSaved") == "true waiting.urp"
    assert dashboard.ask("programState") == "PLAYING waiting.urp"
    assert dashboard.ask("running") == "Program running: true"
    assert dashboard.ask("play") == "Failed to execute: play"
    assert dashboard.ask("load waiting.urp") == (
        "Error while loading program: waiting.urp"
    )
    assert dashboard.ask("pause") == "Pausing program"
    dashboard.until("programState", "PAUSED waiting.urp")
    assert dashboard.ask("running") == "Program running: false"
    assert dashboard.ask("pause") == "Failed to execute: pause"
    assert dashboard.ask("play") == "Starting program"
    dashboard.until("programState", "PLAYING waiting.urp")
    assert dashboard.ask("stop") == "Stopped"
    dashboard.until("programState", "STOPPED waiting.urp")
    assert rig.robot.arm.control_box.state.digital_outputs[3]


def test_a_program_with_an_error_is_not_loaded(dashboard):
    assert dashboard.ask("load waiting.script") == "Loading program: waiting.script"
    assert dashboard.ask("load wrong.script") == (
        "Error while loading program: wrong.script"
    )
    assert dashboard.ask("get loaded program") == "Loaded program: waiting.script"


def test_the_client_of_ur_rtde_works(rig):
    from dashboard_client import DashboardClient

    client = DashboardClient(rig.host)
    client.connect()
    assert client.isConnected()
    assert client.polyscopeVersion() == "5.25.1.0"
    assert client.robotmode() == "Robotmode: RUNNING"
    assert client.safetystatus() == "Safetystatus: NORMAL"
    assert client.getRobotModel() == "UR5"
    assert client.getSerialNumber().isdigit()
    assert client.isInRemoteControl()
    client.popup("Hello")
    client.closePopup()
    client.addToLog("from ur_rtde")
    with pytest.raises(RuntimeError, match="File not found"):
        client.loadURP("absent.urp")
    client.loadURP("waiting.urp")
    client.play()
    assert client.running()
    client.pause()
    assert client.programState() == "PAUSED waiting.urp"
    client.stop()
    assert not client.running()
    client.powerOff()
    client.powerOn()
    client.brakeRelease()
    client.quit()


def test_a_cb3_has_its_own_commands():
    with ur_rig(arm="ur5", gripper=None) as rig:
        dashboard = rig.dashboard()
        assert dashboard.ask("PolyscopeVersion") == "URSoftware 3.15.8.0 (tool0)"
        assert dashboard.ask("setUserRole locked") == "Setting user role: LOCKED"
        assert dashboard.ask("getUserRole") == "LOCKED"
        assert dashboard.ask("setUserRole king") == "Failed setting user role: king"
        assert dashboard.ask("version") == "could not understand: 'version'"
        assert dashboard.ask("get robot model") == "UR5"
        dashboard.close()


def test_a_driver_sends_its_program_when_it_is_played(rig, external):
    """As UR's driver does: two parts, and the connection stays open."""
    with socket.create_server((rig.host, 50002)) as server:
        for text in ('textmsg("first")', 'textmsg("second")'):
            server.settimeout(20.0)
            external.send("play")
            driver, _ = server.accept()
            with driver:
                assert driver.recv(100) == b"request_program\n"
                driver.sendall(f"# HEADER_BEGIN\n{text}\n".encode())
                driver.sendall(b"# HEADER_END\nwhile True:\n  sync()\nend\n")
                assert external.read() == "Starting program"
            external.until("programState", "PLAYING external_control.urp")
            assert external.ask("stop") == "Stopped"
            external.until("programState", "STOPPED external_control.urp")


def test_a_driver_that_is_absent_or_sends_a_wrong_program_starts_nothing(rig, external):
    assert external.ask("play") == "Failed to execute: play"
    with socket.create_server((rig.host, 50002)) as server:
        server.settimeout(20.0)
        external.send("play")
        driver, _ = server.accept()
        with driver:
            driver.sendall(b"movej(\n")
            assert external.read() == "Failed to execute: play"
    assert external.ask("running") == "Program running: false"
