"""Measured data on the page: files and their columns, looks, beside runs, fits."""
