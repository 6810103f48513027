"""Designs of balancers with balls in races: what fits, what is stable, what runs with scatter show, and which are best."""
