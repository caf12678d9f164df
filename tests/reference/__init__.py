"""Independent reference of the wiper drive, for tests: NumPy and SciPy only, nothing shared with ``cosim``."""
