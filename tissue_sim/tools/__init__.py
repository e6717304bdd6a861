"""What does the robot hold? Two arms: kinematics, instruments, contact surfaces and meshes."""
