"""The command line: parse, call a public function, show. It computes nothing itself."""

from autobalancer.cli.main import app

__all__ = ["app"]
