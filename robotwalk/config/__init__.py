"""Configuration files: positions, schema, and where they are found."""
