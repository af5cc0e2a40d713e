"""Results of known learning methods in the tasks of ``tool0.gym``."""
