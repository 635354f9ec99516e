"""A person or a program drives: one file for each input device, all of which ask for one kind of command.

Devices (`keyboard`, `gamepad`, `socket`) are polled; what they ask goes to the `helm`, which lets one driver at a time
have the robot and hears `stop` from anyone.
"""
