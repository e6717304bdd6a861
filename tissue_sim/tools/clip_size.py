"""Define the size of the applier's clips: medium-large polymer clips."""

CLIP_LENGTH_M = 0.0095  # assumed: length of the legs
CLIP_WIDTH_M = 0.0022  # assumed: width along the tube
