"""Algebraic loops of components that may be set and read at will, and their solution."""
