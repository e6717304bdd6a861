"""The parts of the episode's loop: its steps, settings, inbox and bookkeeping."""
