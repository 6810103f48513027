"""Answers of measured signals: channels, orders, spectra."""
