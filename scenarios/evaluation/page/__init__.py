"""A report as a page; sections that are alike share a file."""
