"""What does a whole sentence say that orders nothing of arms and tubes?"""
