"""How are demonstrations kept on disk? In the layout of LeRobot's dataset v3."""
