"""What keeps the instruments within what the robot can do and the anatomy allows."""
