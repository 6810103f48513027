"""Explicit Runge-Kutta integration with step control, dense output, events and sampling, all compiled."""
