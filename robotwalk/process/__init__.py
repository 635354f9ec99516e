"""The loop in a process of its own: how it is told and heard, who drives it, who watches over it."""
