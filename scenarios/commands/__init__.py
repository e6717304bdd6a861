"""The commands, each in its own file; heavy imports happen only when a command runs."""
