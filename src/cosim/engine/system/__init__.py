"""What is simulated and how: components, connections, channels, faults, roles, the graph of dependence, the method."""
