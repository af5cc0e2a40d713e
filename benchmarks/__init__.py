"""Figures with which tool0 is assessed.

They are ratios that are measured in one run.
"""
