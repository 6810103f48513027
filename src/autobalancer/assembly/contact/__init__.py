"""Contacts of balls: which meet, and what of them depends on the speed of an impact."""
