"""Define the room that the expert leaves around its open jaws, which policies get as input."""

CLEARANCE_M = 0.0018  # between tube and finger on either side
OFF_CENTRE_M = 0.0013  # the tube nearer to one finger, so that the other finger's side stays free
FIRM_ROOM_M = 0.0006  # to a structure at risk or the other arm: the filter keeps 0.5 mm
