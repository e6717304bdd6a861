"""What is a policy told of the field? Exact state, a model of cameras, or pictures."""
