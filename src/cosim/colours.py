"""Okabe and Ito's colours, which stay apart for colour-blind readers; yellow is left out, it is too pale for a line.

Source: M. Okabe, K. Ito, Color Universal Design (2008).
"""

from __future__ import annotations

BLUE = "#0072B2"
RED = "#D55E00"
GREEN = "#009E73"
PINK = "#CC79A7"
SKY = "#56B4E9"
ORANGE = "#E69F00"
BLACK = "#000000"
