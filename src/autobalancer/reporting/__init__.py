"""Reports: what is known of a machine, on pages that can be signed."""
