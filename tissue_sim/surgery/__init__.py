"""What instruments do to tissue: grasp, clip, cut and tear, with leaks and injuries that follow."""
