"""Balls free in three dimensions in chambers that turn: contacts, body, time stepping."""
