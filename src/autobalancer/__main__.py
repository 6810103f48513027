"""``python -m autobalancer``."""

from autobalancer.cli import app

app()
