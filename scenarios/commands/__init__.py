"""The commands, each in its own file, and their options; heavy imports happen when one runs."""
