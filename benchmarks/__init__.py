"""Figures with which tool0 is assessed.

Each figure is a ratio of measurements in the same run.
"""
