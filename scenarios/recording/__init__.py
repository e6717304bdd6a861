"""How an episode is kept and run again, to the bit."""
