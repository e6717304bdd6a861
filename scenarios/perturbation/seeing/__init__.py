"""What can disturb only what is seen: the cameras, their pictures, or the sensed points?"""
