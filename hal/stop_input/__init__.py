"""A stop button on a line of a serial port, or on a board that talks: whether the robot is to stop."""
