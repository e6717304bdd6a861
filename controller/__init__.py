"""How to move: kinematics, expert, diffusion policy and safety."""
