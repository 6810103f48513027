"""Pictures and films of deep chambers."""
