"""Unbalance from measured vibration, and the masses that remove it."""
