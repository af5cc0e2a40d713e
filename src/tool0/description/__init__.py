"""The robot as data: xacro, URDF, and the resulting model."""
