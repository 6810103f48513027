"""The drawing of a machine before it runs: what is where along its axis, and its races from above."""
