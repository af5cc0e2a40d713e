"""The tasks of ``tool0 demo``, which use only the public Python API."""
