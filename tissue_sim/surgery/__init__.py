"""What do instruments do to tissue? Grasps, clips, cuts, tears, and their leaks and injuries."""
