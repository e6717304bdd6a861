"""How the tools would move if the hidden state of the world were known. Privileged."""
