"""What is a policy told of the field? Exact simulator state, and pictures."""
