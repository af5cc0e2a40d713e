"""Creates the report of ``tool0 doctor``."""
