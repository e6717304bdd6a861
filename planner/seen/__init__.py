"""What can be concluded from the observation alone?"""
