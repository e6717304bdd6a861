"""The size of the clips that the applier is loaded with: medium-large polymer clips."""

CLIP_LENGTH_M = 0.0095  # assumed: of the legs
CLIP_WIDTH_M = 0.0022  # assumed: along the tube
