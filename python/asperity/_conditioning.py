"""Preparation of measured maps for a solve: the methods of HeightMap that return a new map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _arguments as _a
from ._columns import Lazy, needed, shown

if TYPE_CHECKING:
    from ._maps import HeightMap

np: Any = Lazy("numpy", "numpy", "a method of HeightMap")
ndimage, sparse, solvers, signal, interpolate = (
    Lazy(f"scipy.{name}", "theory", "a method of HeightMap")
    for name in ("ndimage", "sparse", "sparse.linalg", "signal", "interpolate"))
# Tukey's biweight: residuals beyond 4.4478 times the median of their absolute values count nothing
# (ISO 16610-31, 4.4478 = 3 deviations of a normal distribution).
TUKEY = 4.4478
# The fit converges linearly; the weights are final when it moves by less than this share of the
# median residual.
SETTLED, MOST_FITS = 1e-9, 100
# Deviations at which the Gaussian of a filter is cut: 2e-9 of its weight lie beyond.
CUT = 6.0


class Conditioning:
    """Methods of a height map that return a new map, whose `notes` state what was done."""

    def level(self: Any, degree: int = 1, robust: bool = False) -> HeightMap:
        """Subtract a polynomial in x and y of a total degree: 0 is the mean, 1 a plane, 2 a form;
        `robust` by Tukey's biweight, which leaves outliers out, in place of least squares.
        """
        number = 1 if self.periodic else min(self.shape)
        degree = _a.whole("degree", degree, f"0 to {number - 1}" + self.periodic * (
            ": a periodic map without a plane would not be periodic"), range(number))
        fit = _fitted(self.heights, degree, _a.flag("robust", robust))
        return _new(self, self.heights - fit, f"level: degree {degree}, " + (
            "Tukey's biweight" if robust else "least squares"))

    def fill(self: Any) -> HeightMap:
        """Fill missing pixels by the solution of Laplace's equation through the pixels around them,
        with zero slope across a free edge."""
        heights = np.array(self.heights)
        missing = np.isnan(heights)
        count = int(missing.sum())
        if count == heights.size:
            raise _a.wrong("heights", "no measured pixel", "one at least")
        if count:
            heights[missing] = _harmonic(heights, missing, self.spacing, self.periodic)
        return _new(self, heights, f"fill: {count} missing pixels, harmonic")

    def filter(self: Any, shortest: float | None = None, longest: float | None = None) -> HeightMap:
        """Keep the wavelengths between two cut-offs, by the Gaussian filter of ISO 16610-61.

        A wave of the length L passes the cut-off C with the factor exp(-ln 2 (C/L)**2), one half
        at L = C. A free map is levelled by a plane first, which `shortest` alone puts back. At the
        edge and beside missing pixels the weights of the measured pixels are scaled to the sum 1.
        """
        cuts = [None if one is None else _a.number(name, one)
                for name, one in (("shortest", shortest), ("longest", longest))]
        given = [one for one in cuts if one is not None]
        if not given or min(given) <= 0.0 or (len(given) == 2 and given[0] >= given[1]):
            raise _a.wrong("shortest, longest", f"{shortest}, {longest}",
                           "one or two wavelengths above 0, ascending")
        heights = np.array(self.heights)
        measured = np.isfinite(heights)
        mode = "wrap" if self.periodic else "constant"

        def smoothed(values: Any, cut: float) -> Any:
            # exp(-pi (x/(a C))**2) with a = sqrt(ln 2/pi): a Gaussian of this deviation.
            widths = [cut * math.sqrt(math.log(2.0) / 2.0) / (math.pi * step)
                      for step in self.spacing[::-1]]
            total, weight = (ndimage.gaussian_filter(one, widths, mode=mode, truncate=CUT)
                             for one in (np.where(measured, values, 0.0), measured.astype(float)))
            return total / np.where(measured, weight, 1.0)

        plane = _fitted(heights, 0 if self.periodic else 1, False)
        rest = heights - plane
        if cuts[0] is not None:
            rest = smoothed(rest, cuts[0])
        rest = rest + plane if cuts[1] is None else rest - smoothed(rest, cuts[1])
        unit = f" {self.unit}" if self.unit else ""
        names = " and ".join(f"{name} {shown(one)}{unit}"
                             for name, one in zip(("above", "below"), cuts) if one is not None)
        return _new(self, np.where(measured, rest, np.nan),
                    f"filter: Gaussian (ISO 16610-61), wavelengths {names}")

    def align(self: Any) -> HeightMap:
        """Shift each row so that the median of its differences from the row before is 0. That
        removes steps between the lines of a scan along x, and a slope along y."""
        heights, last = np.array(self.heights), math.nan
        for row in heights:
            steps = (row - last)[np.isfinite(row - last)]
            row -= np.median(steps) if steps.size else 0.0
            if np.isfinite(row).any():
                last = row
        return _new(self, heights, "align: rows, by the medians of their differences")

    def crop(self: Any, x: Sequence[float] | None = None,
             y: Sequence[float] | None = None) -> HeightMap:
        """Keep the pixels whose centres lie between two places along x and y, from the edge of the
        first pixel, in the unit of the map. The result is a free map."""
        parts, words = [], []
        for name, ends, step, size in zip("xy", (x, y), self.spacing, self.sizes):
            first, last = (0.0, size) if ends is None else _a.pair(name, ends)
            parts.append(slice(round(first / step), round(last / step)))
            words.append(f"{name} {shown(first)} to {shown(last)}")
            if not 0 <= parts[-1].start < parts[-1].stop <= round(size / step):
                raise _a.wrong(name, words[-1][2:], f"two ascending places from 0 to {shown(size)}")
        return _new(self, self.heights[tuple(parts[::-1])], f"crop: {', '.join(words)}",
                    periodic=False)

    def resample(self: Any, spacing: float | Sequence[float]) -> HeightMap:
        """Interpolate on pixels of the nearest spacing that divides the sides of the map: periodic
        ones by their Fourier series; others by cubic splines through the centres of the pixels, for
        a coarser map after `filter(shortest=...)`."""
        heights = np.array(self.heights)
        if np.isnan(heights).any():
            raise _a.wrong("heights", "missing pixels", "none: fill() first")
        steps, made = list(self.spacing), _a.pair("spacing", spacing)
        for axis, size in enumerate(self.sizes[:1 if self.is_profile else 2]):
            if not made[axis] > 0.0:
                raise _a.wrong("spacing", str(made[axis]), "more than 0")
            number, count = max(1, round(size / made[axis])), self.shape[1 - axis]
            places, wanted = (np.arange(n) + 0.5 for n in (count, number))
            heights = signal.resample(heights, number, axis=1 - axis) if self.periodic else \
                interpolate.make_interp_spline(places, heights, min(3, count - 1), axis=1 - axis)(
                    wanted * count / number)
            steps[axis] = size / number
        kind = "Fourier series" if self.periodic else "cubic splines"
        return _new(self, heights, f"resample: {heights.shape[1]} x {heights.shape[0]} pixels, "
                    f"{kind}", spacing=(steps[0], steps[1]))

    def parameters(self: Any) -> dict[str, float]:
        """Sa, Sq, Ssk, Sku, Sp, Sv, Sz, Sdq and Sdr of ISO 25178-2 about the mean: Sdq as the
        `rms_slope` of `asperity.summits`, Sdr, a share, by triangles of three neighbouring pixels.

        Examples:
            >>> found = asperity.HeightMap([[0, 1, 0, -1]] * 4, 1, periodic=True).parameters()
            >>> print(f"{found['Sa']:.4f} {found['Sq']:.4f} {found['Sdq']:.4f} {found['Sdr']:.4f}")
            0.5000 0.7071 1.0000 0.4142
        """
        from ._calls import summits
        z = np.asarray(self.heights) - np.nanmean(self.heights)
        known = z[np.isfinite(z)]
        wide = np.pad(z, ((0, 1), (0, 1)), mode="wrap") if self.periodic else z
        along, across = (np.diff(wide, axis=axis) / step
                         for axis, step in ((1, self.spacing[0]), (0, self.spacing[1])))
        areas = sum(np.sqrt(1.0 + one**2 + other**2) for one in (along[1:], along[:-1])
                    for other in (across[:, 1:], across[:, :-1])) / 4.0
        q = math.sqrt((known**2).mean())
        values = {"Sa": np.abs(known).mean(), "Sq": q, "Ssk": (known**3).mean() / q**3,
                  "Sku": (known**4).mean() / q**4, "Sp": known.max(), "Sv": -known.min(),
                  "Sz": known.max() - known.min(),
                  "Sdq": summits(self, level="none").statistics["rms_slope"],
                  "Sdr": np.nanmean(areas) - 1.0}
        return {name: float(value) for name, value in values.items()}

    def to_topography(self: Any) -> Any:
        """The map as a topography of SurfaceTopography, whose heights are indexed `[x, y]`, with
        missing pixels masked; a profile as a uniform line scan."""
        library: Any = needed("SurfaceTopography", "maps", "a topography")
        heights = np.array(self.heights).T
        if np.isnan(heights).any():
            heights = np.ma.masked_invalid(heights)
        if self.is_profile:
            return library.UniformLineScan(heights[:, 0], self.sizes[0], periodic=self.periodic,
                                           unit=self.unit)
        return library.Topography(heights, self.sizes, periodic=self.periodic, unit=self.unit)


def _new(of: Any, heights: Any, note: str, *, spacing: tuple[float, float] | None = None,
         periodic: bool | None = None) -> HeightMap:
    """A map with other heights and one more note."""
    made: HeightMap = type(of)(heights, spacing or of.spacing, of.unit,
                               of.periodic if periodic is None else periodic)
    made.notes, made.is_profile = [*of.notes, note], of.is_profile
    return made


def _fitted(heights: Any, degree: int, robust: bool) -> Any:
    """The polynomial of a total degree that is nearest to the measured heights."""
    measured = np.isfinite(heights)
    along_y, along_x = (np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, number), degree)
                        for number in heights.shape)
    powers = [(i, j) for j in range(degree + 1) for i in range(degree + 1 - j)]
    terms = np.stack([np.multiply.outer(along_y[:, j], along_x[:, i])[measured]
                      for i, j in powers], axis=1)
    values, weights = heights[measured], 1.0
    found = np.linalg.lstsq(terms, values, rcond=None)[0]
    for _ in range(MOST_FITS if robust else 0):
        misses = np.abs(values - terms @ found)
        middle = float(np.median(misses))
        if middle <= 1e-14 * np.abs(values).max():
            break
        weights = np.maximum(0.0, 1.0 - (misses / (TUKEY * middle))**2)[:, None]
        last, found = found, np.linalg.lstsq(terms * weights, values * weights[:, 0], rcond=None)[0]
        if np.abs(found - last).max() <= SETTLED * middle:
            break
    return sum(value * np.multiply.outer(along_y[:, j], along_x[:, i])
               for value, (i, j) in zip(found, powers))


def _harmonic(heights: Any, missing: Any, spacing: tuple[float, float],
              periodic: bool) -> Any:
    """Heights of the missing pixels, which solve Laplace's equation by differences."""
    places = np.argwhere(missing)
    count = len(places)
    numbers = np.full(heights.shape, -1)
    numbers[missing] = np.arange(count)
    matrix = sparse.csr_matrix((count, count))
    right = np.zeros(count)
    for step, weight in (((0, 1), spacing[0]**-2), ((1, 0), spacing[1]**-2)):
        for beside in (places + step, places - step):
            if periodic:
                beside = beside % heights.shape
            inside = ((beside >= 0) & (beside < heights.shape)).all(axis=1)
            own, other = np.flatnonzero(inside), tuple(beside[inside].T)
            unknown = numbers[other] >= 0
            right[own[~unknown]] += weight * heights[other][~unknown]
            rows = np.concatenate([own, own[unknown]])
            columns = np.concatenate([own, numbers[other][unknown]])
            signs = np.where(np.arange(len(rows)) < len(own), weight, -weight)
            matrix = matrix + sparse.csr_matrix((signs, (rows, columns)), (count, count))
    return solvers.spsolve(matrix.tocsc(), right)
