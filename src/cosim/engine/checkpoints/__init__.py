"""The state of a run, taken, written to a file and gone on from."""
