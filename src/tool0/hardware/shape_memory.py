"""Memory that holds an engine's shapes, for compiled code that measures distances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class ShapeMemory(NamedTuple):
    """Functions and arrays of an engine.  Fields of type ``int`` are addresses."""

    kinematics: int
    """Function ``void kinematics(const void *model, void *data)``, which computes the
    poses of the shapes."""
    distance: int
    """Function ``double distance(const void *model, void *data, int first, int second,
    double most, double *ends)``, which returns the distance between two shapes, limited
    to ``most`` [m]."""
    model: int
    data: int
    position: FloatArray
    centres: FloatArray
    """Centers of the shapes in the world frame [m], shape (n_shapes, 3)."""
    rotations: FloatArray
    """Rotations of the shapes in the world frame, shape (n_shapes, 9)."""
    axes: FloatArray
    """Axes of the joints in the world frame, shape (n, 3)."""
    anchors: FloatArray
    """A point on each joint axis in the world frame [m], shape (n, 3)."""
    bodies: FloatArray
    """Rotations of the bodies in the world frame, shape (n, 9)."""
    radii: FloatArray
    """Radii of bounding spheres of the shapes [m], shape (n_shapes,); 0 for planes."""
    boxes: FloatArray
    """Centers and half sizes of bounding boxes of the shapes [m], shape (n_shapes,
    6)."""
