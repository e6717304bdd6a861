"""What does the safety filter see: where the obstacles are, and what the jaws hold?"""
