"""What is drawn on the page, one kind of thing a file."""
