"""Measures of a finished run, computed from its record by compiled code that needs neither Python nor its lock.

All functions keep the order of every sum and contract nothing, so that one quantity has the same bits wherever it is asked for.
"""
