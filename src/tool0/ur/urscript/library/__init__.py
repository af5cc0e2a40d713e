"""The functions of URScript that programs can call, grouped by subject.

Names, order of arguments and defaults follow UR's URScript manual 5.x. Each module
contains a tuple ``FUNCTIONS``.
"""
