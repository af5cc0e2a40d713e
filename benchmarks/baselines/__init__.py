"""What known methods of learning achieve in the tasks of ``tool0.gym``."""
