"""How do the tools carry out each task if the world's hidden state is known? Privileged."""
