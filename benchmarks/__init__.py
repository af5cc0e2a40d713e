"""Figures that assess tool0, as ratios of measurements in the same run.

They are ratios that are measured in one run.
"""
