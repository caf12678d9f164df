"""The native loop: its sources, how they are compiled and loaded, and the structures that it shares with Python."""
