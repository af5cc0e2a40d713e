"""Rules for robots in URDF and xacro.  The rules never raise exceptions."""
