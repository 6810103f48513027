"""Rigid contacts of guided balls: balls that touch are one ball, and impacts take no time."""
