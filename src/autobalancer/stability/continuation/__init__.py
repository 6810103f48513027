"""Curves of steady states over a parameter, their special points, and curves of these over two parameters."""
