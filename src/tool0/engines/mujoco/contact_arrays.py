"""Arrays with the contacts of many worlds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tool0.description.transform_arrays import Array
from tool0.engines.mujoco.world import MujocoWorld

Names = frozenset[str]
"""Names of links, objects or the ground."""
AXES = np.arange(6)


class ContactArrays(NamedTuple):
    """Array of m contacts, each of which is the resultant of a pair in one world.

    A resultant combines all contact points of a pair.  The fields have the names and
    the order of the fields of ``Contact``.
    """

    world: NDArray[np.intp]
    """Number of the world, shape (m,)."""
    first: NDArray[np.str_]
    """First link, object or ground of each pair, shape (m,)."""
    second: NDArray[np.str_]
    """Second link, object or ground of each pair, shape (m,)."""
    point: Array
    """Mean of the contact points, weighted by normal force [m], shape (m, 3)."""
    force: Array
    """Force of ``first`` on ``second`` [N], shape (m, 3)."""
    torque: Array
    """Torque of ``first`` on ``second`` about ``point`` [N·m], shape (m, 3)."""
    normal: Array
    """Mean normal from ``first`` to ``second``, weighted by normal force, shape (m, 3).
    The normal has unit length; it is zero if the normals of the contact points
    cancel."""
    distance: Array
    """Smallest distance between the surfaces [m], shape (m,).  The distance is negative
    if the shapes overlap."""


def contact_arrays(
    worlds: Sequence[MujocoWorld], first: Names | None, second: Names | None
) -> ContactArrays:
    """Return the contacts between ``first`` and ``second`` in the last step.

    None selects all links, objects and the ground.  If ``first`` is given, a member of
    ``first`` is the first element of each pair.
    """
    points = [_points(world, first, second) for world in worlds]
    numbers = np.repeat(np.arange(len(worlds)), [len(each.geoms) for each in points])
    geoms, is_reversed, frames, wrench, places, distances = map(
        np.concatenate, zip(*points, strict=True)
    )
    geoms = np.where(is_reversed[:, None], geoms[:, ::-1], geoms)
    sign = np.where(is_reversed, -1.0, 1.0)[:, None]
    frame = frames.reshape(-1, 3, 3)
    normals, weight = sign * frame[:, 0], wrench[:, 0]
    forces = sign * np.einsum("pij,pi->pj", frame, wrench[:, :3])
    torques = sign * np.einsum("pij,pi->pj", frame, wrench[:, 3:])

    names = worlds[0].geom_owners
    owners = sorted(set(names))
    pairs = np.array([owners.index(name) for name in names], dtype=np.intp)[geoms]
    begins, group = _groups(numbers, pairs, len(owners))
    heads = pairs[begins]
    sign = np.where(pairs[:, 0] == heads[group, 0], 1.0, -1.0)[:, None]
    normals, forces, torques = sign * normals, sign * forces, sign * torques

    def total(values: Array) -> Array:
        found = np.zeros((len(begins), *values.shape[1:]))
        np.add.at(found, group, values)
        return found

    point = total(weight[:, None] * places) / total(weight)[:, None]
    torques += np.cross(places - point[group], forces)
    normal = total(weight[:, None] * normals)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    distance = np.full(len(begins), np.inf)
    np.minimum.at(distance, group, distances)
    labels = np.array(owners)
    return ContactArrays(
        world=numbers[begins],
        first=labels[heads[:, 0]],
        second=labels[heads[:, 1]],
        point=point,
        force=total(forces),
        torque=total(torques),
        normal=normal / np.where(length > 0.0, length, 1.0),
        distance=distance,
    )


def _groups(
    numbers: NDArray[np.intp], pairs: NDArray[np.intp], count: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first point of each pair in each world, and the pair of each point.

    Args:
        numbers: Numbers of the points' worlds, shape (p,).
        pairs: Numbers of the two touching items, in either order and below ``count``,
            shape (p, 2).
        count: Number of items that can touch.
    """
    key = (numbers * count + pairs.min(axis=1)) * count + pairs.max(axis=1)
    _, begins, group = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(begins)  # pairs in the order of their first points
    return begins[order], np.argsort(order)[group.reshape(-1)]


def are_touching(
    worlds: Sequence[MujocoWorld], first: Names, second: Names | None
) -> NDArray[np.bool_]:
    """Return whether ``first`` touches ``second`` in each world, shape (n_worlds,)."""
    return np.array([len(_rows(world, first, second)[0]) > 0 for world in worlds])


class _Points(NamedTuple):
    """The p contact points of one world that have a normal force."""

    geoms: NDArray[np.intp]
    """Numbers of the shapes that touch, shape (p, 2)."""
    is_reversed: NDArray[np.bool_]
    """Whether the second geom of each pair belongs to ``first``, shape (p,)."""
    frame: Array
    """Axes of the contact in the root, as the rows of a rotation matrix, shape (p, 9).
    The x axis points from the first shape to the second shape."""
    wrench: Array
    """Force and torque on the second shape in the axes of the contact, shape (p, 6)."""
    point: Array
    distance: Array


def _rows(
    world: MujocoWorld, first: Names | None, second: Names | None
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the numbers of the contacts, and whether each contact is reversed."""
    contacts = world.data.contact
    addresses = contacts.efc_address
    if not len(addresses) or world.has_no_contact:
        return np.empty(0, np.intp), np.empty(0, np.bool_)
    is_pressed = world.data.efc_force[addresses] != 0.0
    is_pressed &= addresses >= 0
    geoms = contacts.geom
    one = _is_of(world, first)[geoms]
    other = _is_of(world, second)[geoms]
    straight = one[:, 0] & other[:, 1]
    reverse = one[:, 1] & other[:, 0]
    rows = np.flatnonzero(is_pressed & (straight | reverse))
    return rows, ~straight[rows]


def _is_of(world: MujocoWorld, names: Names | None) -> NDArray[np.bool_]:
    if names is None:
        return np.ones(len(world.geom_owners), dtype=np.bool_)
    return world.are_of(names)


def _points(world: MujocoWorld, first: Names | None, second: Names | None) -> _Points:
    """Return the contact points between ``first`` and ``second``."""
    rows, is_reversed = _rows(world, first, second)
    contacts, forces = world.data.contact, world.data.efc_force
    # The friction cone is elliptic.  A contact has up to six constraint rows: the
    # normal force, the forces along the other axes of the frame, and the torques about
    # the axes.  Only the first ``dim`` rows of a contact exist.
    is_there = contacts.dim[rows, None] > AXES
    places = np.where(is_there, contacts.efc_address[rows, None] + AXES, 0)
    return _Points(
        contacts.geom[rows],
        is_reversed,
        contacts.frame[rows],
        np.where(is_there, forces[places] if len(rows) else 0.0, 0.0),
        contacts.pos[rows],
        contacts.dist[rows],
    )
