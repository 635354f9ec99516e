"""What a computer has, and lacks, to run a robot; and the one command that mends each lack."""
