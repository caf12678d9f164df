"""FMUs: what is on disk, the loaded library, and one instance with its calls."""
