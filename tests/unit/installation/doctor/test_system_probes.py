import os
from pathlib import Path

import pytest
from machine import add_program, make_machine

from tool0.installation.doctor import system_probes
from tool0.installation.doctor.report import ProbeResult


def gpu(root: Path) -> ProbeResult:
    (result,) = system_probes.gpu(make_machine(root))
    return result


def test_a_gpu_is_not_needed(tmp_path: Path) -> None:
    result = gpu(tmp_path)
    assert (result.state, result.remedy) == ("missing", "")


def test_nvidia_cards_are_read_without_running_a_program(tmp_path: Path) -> None:
    add_program(tmp_path / "bin/nvidia-smi", "exec sleep 1000")
    card = tmp_path / "proc/driver/nvidia/gpus/0000:01:00.0/information"
    card.parent.mkdir(parents=True)
    card.write_text("Model: \t\t NVIDIA H200\nIRQ:   \t\t 190\n")
    (tmp_path / "proc/driver/nvidia/version").write_text(
        "NVRM version: NVIDIA UNIX x86_64 Kernel Module  550.54.15  Tue Mar  5\n"
    )
    assert gpu(tmp_path).found == "NVIDIA H200, driver 550.54.15"


def test_nvidia_smi_is_run_where_there_are_no_files(tmp_path: Path) -> None:
    add_program(tmp_path / "bin/nvidia-smi", "echo 'NVIDIA H200, 550.54.15'")
    assert gpu(tmp_path).found == "NVIDIA H200, driver 550.54.15"


def test_nvidia_smi_without_a_driver_is_no_gpu(tmp_path: Path) -> None:
    add_program(tmp_path / "bin/nvidia-smi", "echo NVIDIA-SMI has failed; exit 9")
    assert gpu(tmp_path).state == "missing"


def test_a_driver_that_hangs_is_unknown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.installation.doctor.machine.PROGRAM_TIMEOUT", 0.2)
    add_program(tmp_path / "bin/nvidia-smi", "exec /bin/sleep 1000")
    result = gpu(tmp_path)
    assert result.state == "unknown"
    assert "nvidia-smi" in result.found


def test_render_nodes_are_listed_with_their_vendor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for node, vendor in (("renderD128", "0x8086"), ("renderD129", "0x1af4")):
        (tmp_path / "dev/dri").mkdir(parents=True, exist_ok=True)
        (tmp_path / "dev/dri" / node).touch()
        file = tmp_path / "sys/class/drm" / node / "device/vendor"
        file.parent.mkdir(parents=True)
        file.write_text(f"{vendor}\n")
    result = gpu(tmp_path)
    assert (result.state, result.remedy) == ("ready", "")
    assert result.found.startswith("Intel (")
    assert ", a GPU (" in result.found
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may do anything
    assert "usermod -aG render" in gpu(tmp_path).remedy
