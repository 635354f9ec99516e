"""A robot that is not there: real bytes in, a MuJoCo body moves, real bytes out."""
