"""The parts of rosrun clothsim sweep: the plan of cases, their runs on this machine or by Slurm, the table."""
