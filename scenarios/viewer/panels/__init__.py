"""What stands beside the scene on the page, one panel a file."""
