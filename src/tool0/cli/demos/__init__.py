"""The tasks of ``tool0 demo``, written with the public Python API alone."""
