"""Compiled steps of the flow in an annulus."""
