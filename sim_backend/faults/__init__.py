"""What goes wrong with a simulated robot, and when: scripts of faults, their schema and what each does."""
