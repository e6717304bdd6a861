"""What comes of a person's word, and what does the robot answer?"""
