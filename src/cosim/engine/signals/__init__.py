"""How components take part: what each takes from the signals and puts there, and faults of these."""
