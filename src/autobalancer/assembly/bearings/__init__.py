"""Bearings that become stiffer as they deflect."""
