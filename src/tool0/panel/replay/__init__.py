"""``tool0 replay``: the panel of a recording."""
