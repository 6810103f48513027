"""What friction holds, and where balls with friction stop."""
