"""Rubber that softens with the amplitude, from hysteresis loops and from resonances."""
