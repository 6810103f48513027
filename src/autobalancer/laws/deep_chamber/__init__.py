"""What a deep chamber can do at best, in closed form: pick-up, settling, residual."""
