"""Numbers of runs of deep chambers."""
