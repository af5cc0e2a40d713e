"""Figures by which tool0 is judged: ratios, measured side by side in one run."""
