"""Commands for machine files and catalogs."""
