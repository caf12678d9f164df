"""The source's numbers of its figures of the rig."""

NUMBERS = {
    (0.001, "normal"): "4_9",
    (0.001, "disturbed"): "4_10",
    (0.002, "normal"): "4_11",
    (0.002, "disturbed"): "4_12",
    (0.010, "normal"): "4_13",
    (0.010, "disturbed"): "4_14",
    (0.020, "normal"): "4_15",
    (0.020, "disturbed"): "4_16",
    (0.050, "normal"): "4_17",
    (0.050, "disturbed"): "4_18",
}
"""By sampling time [s] and load."""
