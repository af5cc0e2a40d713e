"""The compiled tick: bit-identical to that of Python, without its overhead."""
