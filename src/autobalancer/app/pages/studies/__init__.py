"""Studies and designs on the page: defined, started, watched, resumed, and what came out."""
