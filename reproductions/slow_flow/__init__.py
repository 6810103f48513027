"""Exact solutions of slow flow around spheres, against the finite elements of the drag of a ball."""
