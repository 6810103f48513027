"""Measured receptances: files, and modes fitted to them."""
