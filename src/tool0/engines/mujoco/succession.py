"""From one compiled model to the next, when an object comes or goes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any


def read_meshes(spec: Any, known: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """Give ``spec`` the contents of its mesh files, and return them for the next one.

    A file may change or go while the object made of it stays.

    Args:
        spec: Not compiled yet.
        known: What was read for the spec before it.
    """
    files = {}
    assets = {}
    for mesh in spec.meshes:
        name = mesh.file
        if name not in files:
            if name in known:
                files[name] = known[name]
            elif Path(name).is_file():  # otherwise MuJoCo says what is wrong
                files[name] = Path(name).read_bytes()
        if name in files:
            # mujoco 3.3.0 takes two files of one name in two folders for the same.
            mesh.file = name.replace("/", "|").replace("\\", "|")
            assets[mesh.file] = files[name]
    spec.assets = assets
    return files


def carry_over(old: Any, was: Any, new: Any, now: Any) -> None:
    """Give what is in both models the same state, to the bit.

    Args:
        old: The ``MjModel`` so far.
        was: Its ``MjData``.
        new: That of the same robot and other objects.
        now: Its ``MjData``, which is changed.
    """
    now.time = was.time
    now.ctrl[:], now.act[:] = was.ctrl, was.act  # the robot's alone
    here = {new.joint(i).name for i in range(new.njnt)}
    for name in (old.joint(i).name for i in range(old.njnt)):
        if name in here:
            before, after = was.joint(name), now.joint(name)
            after.qpos[:], after.qvel[:] = before.qpos, before.qvel
            after.qacc_warmstart[:] = before.qacc_warmstart
            after.qfrc_applied[:] = before.qfrc_applied
    here = {new.body(i).name for i in range(new.nbody)}
    for name in (old.body(i).name for i in range(old.nbody)):
        if name in here:
            now.body(name).xfrc_applied[:] = was.body(name).xfrc_applied
