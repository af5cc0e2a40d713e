"""The report of ``tool0 doctor``."""
