"""The robot as data: xacro, URDF, and the model they give."""
