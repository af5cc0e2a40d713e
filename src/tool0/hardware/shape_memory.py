"""Memory with an engine's shapes, for compiled code that measures distances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class ShapeMemory(NamedTuple):
    """Functions and arrays of an engine; integer fields are addresses."""

    kinematics: int
    """``void kinematics(const void *model, void *data)`` places the shapes."""
    distance: int
    """``double distance(const void *model, void *data, int first, int second, double
    most, double *ends)`` returns the distance between two shapes, up to ``most``
    [m]."""
    model: int
    data: int
    position: FloatArray
    centres: FloatArray
    """Centres of the shapes in the world [m], shape (n_shapes, 3)."""
    rotations: FloatArray
    """Rotations of the shapes in the world, shape (n_shapes, 9)."""
    axes: FloatArray
    """Axes of the joints in the world, shape (n, 3)."""
    anchors: FloatArray
    """A point on each axis in the world [m], shape (n, 3)."""
    bodies: FloatArray
    """Rotations of the bodies, shape (n, 9)."""
    radii: FloatArray
    """Radii of spheres around the shapes [m], shape (n_shapes,); 0 for planes."""
    boxes: FloatArray
    """Centre and half sizes of boxes around the shapes [m], shape (n_shapes, 6)."""
