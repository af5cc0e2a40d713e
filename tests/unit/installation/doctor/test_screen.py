import os
from pathlib import Path

import pytest
from promised import require_gl

from tool0.installation.doctor import screen
from tool0.installation.doctor.line import Line
from tool0.installation.doctor.machine import Machine


def program(root: Path, name: str, text: str = "") -> None:
    file = root / "bin" / name
    file.parent.mkdir(exist_ok=True)
    file.write_text(f"#!/bin/sh\n{text}\n")
    file.chmod(0o755)


def here(root: Path, *, system: str = "linux", **variables: str) -> Machine:
    environ = {"PATH": str(root / "bin"), **variables}
    return Machine(root=root, environ=environ, system=system)


def gpu(machine: Machine) -> Line:
    (line,) = screen.gpu(machine)
    return line


def browser(machine: Machine) -> Line:
    (line,) = screen.browser(machine)
    return line


def test_a_browser_is_opened_where_there_is_a_desktop(tmp_path: Path) -> None:
    program(tmp_path, "firefox")
    assert "open http://127.0.0.1:8085/" in browser(here(tmp_path)).found
    seen = browser(here(tmp_path, WAYLAND_DISPLAY="wayland-0"))
    assert seen.state == "ready"
    assert "tool0 opens" in seen.found


@pytest.mark.parametrize(
    ("manager", "release", "remedy"),
    [
        ("apt-get", "ID=debian\n", "sudo apt install firefox-esr"),
        ("apt-get", "ID=ubuntu\n", "sudo apt install firefox"),
        ("dnf", "ID=fedora\n", "sudo dnf install firefox"),
        ("zypper", "ID=opensuse\n", "sudo zypper install MozillaFirefox"),
    ],
)
def test_a_browser_is_installed_by_its_name_there(
    tmp_path: Path, manager: str, release: str, remedy: str
) -> None:
    program(tmp_path, manager)
    (tmp_path / "etc").mkdir()
    (tmp_path / "etc/os-release").write_text(release)
    line = browser(here(tmp_path))
    assert (line.state, line.remedy) == ("missing", remedy)
    assert "--panel-host 0.0.0.0" in line.found


@pytest.mark.parametrize(
    ("system", "name"), [("darwin", "Safari"), ("win32", "Microsoft Edge")]
)
def test_some_systems_bring_a_browser(tmp_path: Path, system: str, name: str) -> None:
    line = browser(here(tmp_path, system=system))
    assert line.state == "ready"
    assert line.found.startswith(name)


def test_no_gpu_is_no_harm(tmp_path: Path) -> None:
    line = gpu(here(tmp_path))
    assert (line.state, line.remedy) == ("missing", "")
    assert "none is needed" in line.found


def test_nvidia_s_driver_tells_its_cards_without_being_run(tmp_path: Path) -> None:
    program(tmp_path, "nvidia-smi", "exec sleep 1000")
    card = tmp_path / "proc/driver/nvidia/gpus/0000:01:00.0/information"
    card.parent.mkdir(parents=True)
    card.write_text("Model: \t\t NVIDIA H200\nIRQ:   \t\t 190\n")
    (tmp_path / "proc/driver/nvidia/version").write_text(
        "NVRM version: NVIDIA UNIX x86_64 Kernel Module  550.54.15  Tue Mar  5\n"
    )
    assert gpu(here(tmp_path)).found == "NVIDIA H200, driver 550.54.15"


def test_nvidia_smi_is_asked_where_there_are_no_files(tmp_path: Path) -> None:
    program(tmp_path, "nvidia-smi", "echo 'NVIDIA H200, 550.54.15'")
    assert gpu(here(tmp_path)).found == "NVIDIA H200, driver 550.54.15"


def test_nvidia_smi_without_a_driver_is_no_gpu(tmp_path: Path) -> None:
    program(tmp_path, "nvidia-smi", "echo NVIDIA-SMI has failed; exit 9")
    assert gpu(here(tmp_path)).state == "missing"


def test_a_hanging_driver_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.installation.doctor.machine.PATIENCE", 0.2)
    program(tmp_path, "nvidia-smi", "exec /bin/sleep 1000")
    line = gpu(here(tmp_path))
    assert line.state == "unknown"
    assert "nvidia-smi does not answer" in line.found


def test_nodes_to_draw_by_are_told_with_whose_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for node, vendor in (("renderD128", "0x8086"), ("renderD129", "0x1af4")):
        (tmp_path / "dev/dri").mkdir(parents=True, exist_ok=True)
        (tmp_path / "dev/dri" / node).touch()
        file = tmp_path / "sys/class/drm" / node / "device/vendor"
        file.parent.mkdir(parents=True)
        file.write_text(f"{vendor}\n")
    line = gpu(here(tmp_path))
    assert line.state == "ready"
    assert line.remedy == ""
    assert line.found.startswith("Intel (")
    assert ", a GPU (" in line.found
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may do anything
    line = gpu(here(tmp_path))
    assert "usermod -aG render" in line.remedy
    assert "may not use it" in line.found


def test_whether_cameras_draw_is_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program(tmp_path, "apt-get")
    monkeypatch.setenv("MUJOCO_GL", "disable")
    (line,) = screen.cameras(here(tmp_path))
    assert line.state == "missing"
    assert "MUJOCO_GL is 'disable'" in line.found
    assert line.remedy == "sudo apt install libegl1 libopengl0 libgl1-mesa-dri"
    monkeypatch.delenv("MUJOCO_GL")
    require_gl()
    (line,) = screen.cameras(here(tmp_path))
    assert line.state == "ready"
    assert line.found.startswith("draw without a window, by ")
