"""Contact between two rough surfaces of spherical asperities, or of measured height maps.

    >>> import asperity
    >>> results = asperity.solve("data/examples/one_pair.scene")
    >>> print(f"{results.states['load'][-1]:.3f}")
    267.508

Units are those of the scene, any consistent set: with mm and N, moduli and pressures are in MPa.
A card deck brings cm, N and N/cm2. Angles are radians. Heights are indexed `[y, x]`.
"""

from . import _library as _c
from . import theory
from ._accuracy import Accuracy, accuracy
from ._calls import generate, report, summits
from ._columns import Table, Values
from ._errors import AccuracyWarning, ComputeError, InputError, Problem, TheoryWarning
from ._fields import Fields, Stress
from ._half_space import HalfSpace
from ._maps import HeightMap, generate_map, read_map
from ._results import Results, Summits, load
from ._scenes import Scene, solve

__all__ = ["solve", "accuracy", "report", "summits", "generate", "generate_map", "read_map", "load",
           "Scene", "HeightMap", "Results", "Fields", "Stress", "HalfSpace", "Summits", "Accuracy",
           "Table", "Values", "InputError", "ComputeError", "Problem", "TheoryWarning",
           "AccuracyWarning", "theory", "__version__"]

__version__ = _c.VERSION

# Messages and pickles name the public place.
for _name in __all__[:-2]:
    globals()[_name].__module__ = __name__
