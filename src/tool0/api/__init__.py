"""The Python API: handles on a robot and its parts, in this process or another one."""
