"""What does each command do? One file a command; heavy imports happen only when it runs."""
