"""Benchmark tasks: insertion, assembly, a drawer, clutter and a handover."""
