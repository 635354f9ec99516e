"""Foot switches on a board that talks unasked: bytes -> which feet are on the ground."""
