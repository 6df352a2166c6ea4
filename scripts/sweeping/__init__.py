"""What rosrun clothsim sweep is made of: the plan of cases, running them here or by Slurm, the table."""
