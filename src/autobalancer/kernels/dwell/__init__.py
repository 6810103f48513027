"""One speed held and measured."""
