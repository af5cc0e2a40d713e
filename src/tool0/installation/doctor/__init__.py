"""The report of ``tool0 doctor`` on this machine."""
