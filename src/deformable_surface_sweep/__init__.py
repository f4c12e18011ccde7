"""Parameter sweeps: many runs of `simulate` on one machine or a cluster, one table of their results. The command is
deformable_surface_sweep.command; docs/sweeps.md is the user's page."""
