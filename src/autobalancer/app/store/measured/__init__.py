"""Measured files of a user: kept with what their columns mean, looked at, put beside runs, fitted."""
