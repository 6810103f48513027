"""Answers that show themselves as tables."""
