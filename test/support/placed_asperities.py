"""Asperities as arrays, for surfaces too large for lists."""

import numpy as np


class Surface:
    """Places, summit levels and radii of asperities."""

    def __init__(self, x, y, height, radius):
        self.x, self.y, self.height, self.radius = (
            np.ascontiguousarray(np.broadcast_to(a, np.shape(x)), dtype=float)
            for a in (x, y, height, radius))

    def __len__(self):
        return len(self.x)
