"""Serial inertial measurement units: bytes that nobody asked for -> attitude of the robot's base."""
