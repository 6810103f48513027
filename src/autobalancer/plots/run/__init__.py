"""Pictures of a run and of a stepped response."""
