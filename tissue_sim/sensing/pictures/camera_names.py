"""Define the names of the cameras; the file is light to import, so that names are checked first."""

CAMERA_NAMES = ("endoscope_left", "endoscope_right", "wrist_left", "wrist_right")
