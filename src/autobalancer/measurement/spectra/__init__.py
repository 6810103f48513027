"""Spectra of measured signals, their lines, maps over the speed, integration, damping and orbits."""
