"""The ground: courses of elements from `configs/terrains`, laid out, and built into MuJoCo's model."""
