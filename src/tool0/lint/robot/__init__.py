"""Rules for robots in URDF and xacro; they never raise exceptions."""
