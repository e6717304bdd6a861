"""How does the robot carry out a person's words, and answer them?"""
