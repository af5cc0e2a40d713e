"""What is wrong in a robot: rules for URDF and xacro, which never raise."""
