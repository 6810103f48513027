"""What is on the page, made with NiceGUI."""
