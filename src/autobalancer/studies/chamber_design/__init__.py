"""Which balls and which fluid a deep chamber should have: bounds, short runs, full runs of the few best."""
