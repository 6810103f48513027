"""What is known of a machine before a run."""
