"""`asperity.HalfSpace`: displacements, pressures and stresses of arrays against closed forms in
numpy, and refusals."""

import numpy as np
import pytest

E, NU = 2.0, 0.3
G = E / (2 * (1 + NU))
SHAPE, SIDES = (18, 24), (0.01, 0.013)


def test_periodic_displacements_of_waves(package):
    """Boussinesq's and Cerruti's surface displacements in waves (Johnson 1985, chapter 13)."""
    body = package.HalfSpace(SHAPE, SIDES, E, NU, periodic=True)
    rng = np.random.default_rng(3)
    p, qx, qy = rng.standard_normal((3, *SHAPE))
    waves = np.meshgrid(*(2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(SHAPE[::-1], SIDES)))
    q = np.hypot(*waves)
    q[0, 0] = np.inf
    c, s = (wave / q for wave in waves)
    # The shortest wave has no sign: no odd terms.
    sign = np.ones(SHAPE)
    sign[SHAPE[0] // 2] = 0
    sign[:, SHAPE[1] // 2] = 0
    f, fx, fy = (np.fft.fft2(one) for one in (p, qx, qy))
    odd = 1j * (1 - 2 * NU) / (2 * G * q) * sign
    truth = [((1 - NU * c * c) * fx - NU * c * s * sign * fy) / (G * q) + odd * c * f,
             ((1 - NU * s * s) * fy - NU * c * s * sign * fx) / (G * q) + odd * s * f,
             (1 - NU) / (G * q) * f - odd * (c * fx + s * fy)]
    found = body.displacement(p, (qx, qy))
    for one, wave in zip(found, truth):
        assert np.abs(one - np.fft.ifft2(wave).real).max() < 1e-12 * np.abs(found).max()
    assert np.allclose(body.displacement(p), np.fft.ifft2((1 - NU) / (G * q) * f).real, rtol=1e-12,
                       atol=1e-15)
    assert np.abs(body.pressure(body.displacement(p)) - p + p.mean()).max() < 1e-8


def test_free_displacements_far_away(package):
    """One pixel at 30 pixels: the point loads of Boussinesq and Cerruti (Johnson, chapter 3)."""
    body = package.HalfSpace((41, 41), 1.0, E, NU)
    one, none = np.zeros((41, 41)), np.zeros((41, 41))
    one[5, 5] = 1.0
    x, y = 30.0, 12.0
    r = np.hypot(x, y)
    k = 1 / (2 * np.pi * G)
    truths = {"p": [-(1 - 2 * NU) / 2 * x / r**2, -(1 - 2 * NU) / 2 * y / r**2, (1 - NU) / r],
              "qx": [(1 - NU) / r + NU * x * x / r**3, NU * x * y / r**3,
                     (1 - 2 * NU) / 2 * x / r**2]}
    found = {"p": body.displacement(one, (none, none)), "qx": body.displacement(none, (one, none))}
    for name, truth in truths.items():
        assert found[name][:, 17, 35] == pytest.approx(k * np.array(truth), rel=1e-3)
    displacement = body.displacement(one)
    assert np.abs(body.pressure(displacement) - one).max() < 1e-8


def test_strips_are_plane_strain(package):
    """A displacement that is the same along the strip, by one band of pressure, but a constant."""
    body = package.HalfSpace((6, 40), (1.0, 0.5), E, NU, periodic=(False, True))
    p = np.zeros((6, 40))
    p[:, 20] = 1.0
    u = body.displacement(p)
    assert np.abs(u - u[0]).max() < 1e-12
    x = np.arange(40) - 20.0

    def corner(x):
        return x * np.log(np.abs(x)) - x

    truth = -2 * (1 - NU**2) / (np.pi * E) * (corner(x + 0.5) - corner(x - 0.5))
    assert u[0] - u[0, 20] == pytest.approx(truth - truth[20], abs=1e-5 * u.max())


def test_refusals(package):
    body = package.HalfSpace((4, 5), 1.0, E, NU)
    p = np.zeros((4, 5))
    with pytest.raises(package.InputError, match=r"found an array of shape \(5, 4\), expected"):
        body.displacement(p.T)
    with pytest.raises(package.ComputeError, match="depth: found -1.*, expected a number of 0"):
        body.stress(-1.0, p)
    for wrong, text in (({"modulus": 0.0}, "modulus: found 0"), ({"poisson": 0.6}, "ratio: found"),
                        ({"spacing": -1.0}, "spacing: found -1"),
                        ({"layer": (-1.0, 1.0, 0.3)}, "layer: found -1"),
                        ({"layer": (1.0, 1.0, 0.3), "periodic": (True, False)}, "on a strip")):
        given = {"shape": (4, 5), "spacing": 1.0, "modulus": E, "poisson": NU, **wrong}
        with pytest.raises(package.InputError, match=text):
            package.HalfSpace(**given).displacement(p)
    coated = package.HalfSpace((4, 5), 1.0, E, NU, layer=(1.0, 1.0, 0.3))
    with pytest.raises(package.InputError, match="tractions on a layer: found them, expected"):
        coated.displacement(p, (p, p))
    coated = package.HalfSpace((4, 5), 1.0, E, NU, layer=(1.0, 1.0, 0.3), periodic=(True, False))
    with pytest.raises(package.ComputeError, match="found a strip, expected both sides periodic"):
        coated.stress(0.1, p)
