"""One bus for people: who is there, what the registers say, backup and reset. Any brand."""
