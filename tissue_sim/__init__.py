"""Which objects exist in the operating field, and how do they move?"""

import warnings

# SAPIEN brings its own libvulkan where the system has none; `calot doctor` says what it draws with.
warnings.filterwarnings("ignore", message="Failed to find system libvulkan")
