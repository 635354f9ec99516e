"""Garbled bytes by the million, for all that takes bytes from a wire: `make fuzz`, and a short run among the tests.

Every input comes from a seed, so that what fails can be repeated.
"""
