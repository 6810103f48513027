"""Many members of one machine: columns of numbers, runs on all cores, statistics."""
