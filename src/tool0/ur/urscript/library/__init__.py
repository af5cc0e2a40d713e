"""The functions of URScript that programs can call, by subject.

Names, order of arguments and defaults are those of UR's URScript manual 5.x.  Each
module has a tuple ``FUNCTIONS``.
"""
