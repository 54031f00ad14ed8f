"""What is true before any number is computed."""
