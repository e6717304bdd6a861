"""Record an episode, and replay it identically to the bit."""
