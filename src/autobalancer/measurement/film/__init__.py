"""Films of a race: made of a run, and evaluated."""
