"""What of the field is drawn? One kind of thing a file."""
