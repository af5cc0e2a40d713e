"""Joint speed governor for many robots on a Warp device."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np
import warp as wp

from tool0.description.bodies import DynamicBody
from tool0.hardware.robot_hardware import RobotHardware
from tool0.hardware.speed_governor import GovernedDrive
from tool0.kernel.warp_governor import Governed, Remembered, Scratch, govern
from tool0.kernel.warp_laws import Body


@final
class DeviceGovernor:
    """Limiter of the efforts of n robots, equivalent to ``SpeedGovernor``."""

    def __init__(self, hardware: RobotHardware, n: int) -> None:
        """Allocate memory on the current device of Warp."""
        setup, table, own = (
            hardware.setup.governor,
            hardware.table,
            hardware.own_dynamics,
        )
        self._dt, self._n = table.dt, n
        n_joints, n_free = len(hardware.joint_names), len(setup.free)
        n_bodies = len(own.table.bodies)
        free_of = [
            setup.free.index(i) if i in setup.free else -1 for i in range(n_joints)
        ]
        armature = dict(zip(table.to_model, own.armature, strict=True))
        rotors = [armature[i] + hardware.rotors.get(i, 0.0) for i in setup.free]
        compensates = [float(i in table.compensated) for i in range(n_joints)]
        self._drives = wp.array(
            [_governed(each) for each in setup.drives], dtype=Governed
        )
        self._free = wp.array(setup.free, dtype=int)
        self._free_of = wp.array(free_of, dtype=int)
        self._rotors = wp.array(rotors, dtype=float)
        self._compensates = wp.array(compensates, dtype=float)
        bodies = body_structs(own.table.bodies, table.to_model)
        for body, tensor in zip(bodies, own.tensors, strict=True):
            body.tensor = wp.mat33(*np.ravel(tensor).tolist())
        self._bodies = wp.array(bodies, dtype=Body)
        self._requested = wp.zeros((n, n_joints), dtype=float)
        self._scratch = scratch = Scratch()
        scratch.rotations = wp.zeros((n, n_bodies), dtype=wp.mat33)
        scratch.positions = wp.zeros((n, n_bodies), dtype=wp.vec3)
        scratch.linear = wp.zeros((n, n_free), dtype=wp.vec3)
        scratch.angular = wp.zeros((n, n_free), dtype=wp.vec3)
        for name in ("coming", "wanted", "used"):
            setattr(scratch, name, wp.zeros((n, n_free), dtype=float))
        self._remembered = remembered = Remembered()
        remembered.has_before = wp.zeros(n, dtype=int)
        remembered.before = wp.zeros((n, n_joints), dtype=float)
        remembered.has_mobility = wp.zeros(n, dtype=int)
        remembered.mobility = wp.zeros((n, n_free, n_free), dtype=float)
        remembered.posture = wp.zeros((n, n_free), dtype=float)

    @property
    def flags(self) -> tuple[Any, Any]:
        """Flags for known velocities and known mobility; 0 restarts a robot."""
        return self._remembered.has_before, self._remembered.has_mobility

    def launch(
        self, command: Any, loads: Any, position: Any, velocity: Any, applied: Any
    ) -> Any:
        """Return the efforts to request from the drives, computed from Warp arrays.

        ``applied`` contains the efforts of the last step.
        """
        wp.launch(
            govern,
            dim=self._n,
            inputs=[
                self._dt,
                self._drives,
                self._free,
                self._free_of,
                self._rotors,
                self._bodies,
                self._compensates,
                loads,
                command,
                position,
                velocity,
                applied,
                self._scratch,
                self._remembered,
                self._requested,
            ],
            device=self._requested.device,
        )
        return self._requested


def body_structs(bodies: Sequence[DynamicBody], to_model: Sequence[int]) -> list[Any]:
    """Return the bodies as Warp structs, without their inertia tensors.

    ``to_model`` contains the engine's joint number for each joint of the model.
    """
    found = []
    for each, joint in zip(bodies, to_model, strict=True):
        body = Body()
        body.parent, body.is_prismatic = each.parent, int(each.is_prismatic)
        body.master, body.joint = to_model[each.master], joint
        body.multiplier, body.mass = each.multiplier, each.mass
        x, y, z, origin = np.reshape(each.placement, (4, 3)).tolist()
        body.rotation = wp.mat33(*[v for row in zip(x, y, z, strict=True) for v in row])
        body.position, body.center = wp.vec3(*origin), wp.vec3(*each.center)
        found.append(body)
    return found


def _governed(drive: GovernedDrive) -> Any:
    found = Governed()
    for name in ("joint", "speed", "fast", "effort"):
        setattr(found, name, getattr(drive, name))
    return found
