"""From saved states to a labeled result."""
