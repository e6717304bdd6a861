"""What can a policy observe of the field? Exact state, a model of cameras, or pictures."""
