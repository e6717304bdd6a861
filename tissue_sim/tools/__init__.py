"""What the robot holds: two arms, their kinematics, instruments and meshes."""
