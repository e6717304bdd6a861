"""From free text to a command, or a question back."""
