"""What the page keeps: runs in folders, and work in the background."""
