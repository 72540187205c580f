"""An elastic layer bonded to a half-space under waves of pressure: the ordinary differential
equations of plane strain for displacements and tractions, solved with numpy, six unknowns a wave.

For exp(i k x) the state y = (U, W, S, T), with u_x = i U, u_z = W, stress_zz = S, stress_xz = i T,
has dy/dz = M y (Hooke's law and equilibrium). M has the eigenvalues k and -k twice: the columns of
(M + s k)**2 with s = 1 and -1 vanish on the solutions exp(-s k z) (1 + (M + s k) z) v."""

import numpy as np

PAIRS = (  # thickness, layer's G and nu, base's G (0: rigid) and nu
    (1.0, 1.0, 0.3, 0.0, 0.3), (0.2, 5.0, 0.2, 1.0, 0.45), (0.05, 0.1, 0.49, 2.0, 0.3),
    (0.7, 1.0, 0.0, 3.0, 0.1), (0.3, 100.0, 0.25, 1.0, 0.35), (0.01, 1.0, 0.45, 0.2, -0.3))


def matrix(k, shear, ratio):
    lame = 2 * shear * ratio / (1 - 2 * ratio)
    stiff = lame + 2 * shear
    return np.array([
        [0, -k, 0, 1 / shear], [lame * k / stiff, 0, 1 / stiff, 0], [0, 0, 0, k],
        [k * k * (stiff - lame**2 / stiff), 0, -k * lame / stiff, 0]])


def solutions(k, shear, ratio, decays, z):
    """Two solutions at z that decay, or grow, from z = 0, as columns."""
    scale = np.array([1, 1, k * shear, k * shear])
    m = matrix(k, shear, ratio) * scale / scale[:, None] / k
    sign = 1 if decays else -1
    shifted = m + sign * np.eye(4)
    basis = np.linalg.svd(shifted @ shifted)[2][2:].T
    return scale[:, None] * (np.exp(-sign * k * z) * (np.eye(4) + shifted * k * z) @ basis)


def state(k, depth, thickness, shear, ratio, base_shear, base_ratio):
    """The state at a depth under a wave of pressure of 1 at the surface."""
    rigid = base_shear == 0
    base_shear = base_shear or 1.0

    def layer(z):
        return np.hstack([solutions(k, shear, ratio, True, z),
                          solutions(k, shear, ratio, False, z - thickness)])

    system = np.zeros((6, 6))
    system[:2, :4] = layer(0.0)[2:]
    system[2:, :4] = layer(thickness)
    system[2:, 4:] = -solutions(k, base_shear, base_ratio, True, 0.0)
    if rigid:
        system[2:4, 4:] = 0.0
    rows = np.abs(system).max(axis=1)
    columns = np.abs(system / rows[:, None]).max(axis=0)
    found = np.linalg.solve(system / rows[:, None] / columns,
                            np.array([-1, 0, 0, 0, 0, 0]) / rows) / columns
    if depth <= thickness:
        return layer(depth) @ found[:4]
    return solutions(k, base_shear, base_ratio, True, depth - thickness) @ found[4:]


def compliance(k, *materials):
    return state(k, 0.0, *materials)[1]
