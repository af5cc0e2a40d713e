"""The tasks of ``tool0 demo``, written only with the public Python API."""
