"""What is measured while an episode runs?"""
