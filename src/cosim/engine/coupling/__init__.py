"""Components that act on each other continuously: extrapolation, agreement, adaptive macro steps, energies."""
