"""Contact forces of MuJoCo's last step, and objects attached by weld constraints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from tool0.description.transform import Quaternion, Vector3
from tool0.engines.mujoco.model import MIMIC_SOLIMP, MIMIC_SOLREF
from tool0.engines.mujoco.objects import free_joint_name
from tool0.hardware.engine import Contact

ContactPoint = tuple[Vector3, float, Vector3, Vector3]
"""Its position, its weight in the mean, and the force and the torque there."""
MIN_WEIGHT = 1e-12
"""Keeps the mean point defined if the force is zero [N]."""


@final
@dataclass(frozen=True, slots=True)
class Attachment:
    """The pose of an object that is fixed to a link."""

    link: str
    body: str
    """MuJoCo's body that the link is part of."""
    position: Vector3
    """Of the object, in the body [m]."""
    quat_wxyz: Quaternion


def attachment_now(model: Any, data: Any, name: str, link: str) -> Attachment:
    """Return the attachment of object ``name`` to ``link`` at its current pose."""
    mujoco.mj_kinematics(model, data)  # the frames are those before the last step
    body = int(model.site(link).bodyid[0])
    item = data.body(name)
    inverse, inverse_quat = np.zeros(3), np.zeros(4)
    mujoco.mju_negPose(inverse, inverse_quat, data.xpos[body], data.xquat[body])
    position, quat = np.zeros(3), np.zeros(4)
    mujoco.mju_mulPose(position, quat, inverse, inverse_quat, item.xpos, item.xquat)
    x, y, z = position.tolist()
    qw, qx, qy, qz = quat.tolist()
    return Attachment(link, model.body(body).name, (x, y, z), (qw, qx, qy, qz))


def add_attachments(spec: Any, attachments: Mapping[str, Attachment]) -> None:
    """Add a weld for each attached object, by name, as stiff as mimic joints are."""
    for name, attachment in attachments.items():
        weld = spec.add_equality(
            name=_weld_name(name),
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=attachment.body,
            name2=name,
            solref=MIMIC_SOLREF,
            solimp=MIMIC_SOLIMP,
        )
        # Anchor in the object; pose of the object in the body; weight of rotation [m].
        data = np.zeros_like(weld.data)
        data[3:11] = *attachment.position, *attachment.quat_wxyz, 1.0
        weld.data = data


def attachment_points(
    model: Any, data: Any, attachments: Mapping[str, Attachment]
) -> Iterator[tuple[tuple[str, str], ContactPoint]]:
    """Yield what each link exerted on its object in the last step, at its origin.

    The weld acts on the object's free joint only, whose coordinates are a force in the
    world's axes and a torque in the object's.
    """
    for name, attachment in attachments.items():
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        rows &= data.efc_id == model.equality(_weld_name(name)).id
        effort = np.zeros(model.nv)
        mujoco.mj_mulJacTVec(model, data, effort, np.where(rows, data.efc_force, 0.0))
        start = int(model.joint(free_joint_name(name)).dofadr[0])
        force, torque = effort[start : start + 3], effort[start + 3 : start + 6]
        item = data.body(name)
        weight = max(float(np.linalg.norm(force)), MIN_WEIGHT)
        torque = item.xmat.reshape(3, 3) @ torque
        yield (
            (attachment.link, name),
            (_vector(item.xpos), weight, _vector(force), _vector(torque)),
        )


def _weld_name(name: str) -> str:
    return f"{name}/attachment"  # no object's name has a slash


def geom_owners(model: Any) -> tuple[str, ...]:
    """Return the link or object that each geom belongs to, by the geom's number."""
    return tuple(model.geom(i).name.partition("/")[0] for i in range(model.ngeom))


def contact_points(
    model: Any, data: Any, owners: Sequence[str]
) -> Iterator[tuple[tuple[str, str], ContactPoint]]:
    """Yield pairs in contact, and what the first exerts on the second at a point.

    After ``mj_step``, ``data`` still has the contacts and forces of that step: only
    position and velocity are newer.  Plain floats are the fastest here; a force-torque
    sensor reads up to 1000 times a second.  ``owners`` has the name for each geom.
    """
    contacts = data.contact
    wrench = np.zeros(6)
    for i, ((one, two), frame, (x, y, z)) in enumerate(
        zip(
            contacts.geom.tolist(),
            contacts.frame.tolist(),
            contacts.pos.tolist(),
            strict=True,
        )
    ):
        mujoco.mj_contactForce(model, data, i, wrench)
        # In the contact's frame, whose x points from the first shape to the second:
        # a positive force pushes the second away.
        fx, fy, fz, tx, ty, tz = wrench.tolist()
        if fx:
            force, torque = _rotated(frame, fx, fy, fz), _rotated(frame, tx, ty, tz)
            yield (owners[one], owners[two]), ((x, y, z), fx, force, torque)


def merge_by_pair(
    points: Iterable[tuple[tuple[str, str], ContactPoint]],
) -> tuple[Contact, ...]:
    """Return each pair's points as one contact, whichever of the two came first."""
    found: dict[tuple[str, str], list[ContactPoint]] = {}
    for pair, point in points:
        if pair[::-1] in found:
            position, weight, (fx, fy, fz), (tx, ty, tz) = point
            reversed_ = position, weight, (-fx, -fy, -fz), (-tx, -ty, -tz)
            found[pair[::-1]].append(reversed_)
        else:
            found.setdefault(pair, []).append(point)
    return tuple(_resultant(*pair, merged) for pair, merged in found.items())


def _resultant(first: str, second: str, points: list[ContactPoint]) -> Contact:
    total = sum(weight for _, weight, _, _ in points)
    px = sum(weight * x for (x, _, _), weight, _, _ in points) / total
    py = sum(weight * y for (_, y, _), weight, _, _ in points) / total
    pz = sum(weight * z for (_, _, z), weight, _, _ in points) / total
    fx = fy = fz = tx = ty = tz = 0.0
    for (x, y, z), _, (ax, ay, az), (bx, by, bz) in points:
        rx, ry, rz = x - px, y - py, z - pz
        fx, fy, fz = fx + ax, fy + ay, fz + az
        tx += bx + ry * az - rz * ay
        ty += by + rz * ax - rx * az
        tz += bz + rx * ay - ry * ax
    return Contact(first, second, (px, py, pz), (fx, fy, fz), (tx, ty, tz))


def _rotated(frame: list[float], x: float, y: float, z: float) -> Vector3:
    """Return a vector in the axes of ``frame``, its rows, in those of the world."""
    a, b, c, d, e, f, g, h, i = frame
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


def _vector(values: Any) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
