"""A person's word: orders, prohibitions, questions, and what the robot answers."""
