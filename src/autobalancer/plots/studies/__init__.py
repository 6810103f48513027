"""Pictures of studies and of what is decided by them."""
