"""Servos and wires. Knows nothing of walking: one could drive a robot arm with it."""
