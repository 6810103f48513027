"""Studies from a file: what varies and how, drawn, run in chunks that are kept, until enough is known."""
