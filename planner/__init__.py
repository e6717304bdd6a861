"""Which task or correction should the robot carry out next, in a surgeon's words?"""
