"""pytest in a Python that has numpy, pytest and what these need, and no other package.

    python test/support/only_numpy.py PYTEST OPTIONS
"""

import importlib.abc
import re
import sys
from importlib import metadata


def packages_of(*names):
    """Import names of distributions and of all that they require."""
    names, found = list(names), set()
    for name in names:
        try:
            needed = metadata.requires(name) or []
        except metadata.PackageNotFoundError:
            continue
        found.add(name)
        names += [part for line in needed if "extra ==" not in line
                  if (part := re.match(r"[\w.-]+", line)[0]) not in names]
    owners = metadata.packages_distributions()
    return {package for package, owner in owners.items() if found & set(map(str.lower, owner))}


class Refusal(importlib.abc.MetaPathFinder):
    """Refuses to import a package that is installed and not among those that are left."""

    def __init__(self, left):
        self.refused = metadata.packages_distributions().keys() - left

    def find_spec(self, name, path=None, target=None):
        """None, for the next finder, where the package is left."""
        if name.partition(".")[0] in self.refused:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


if __name__ == "__main__":
    sys.meta_path.insert(0, Refusal(packages_of("numpy", "pytest")))
    import pytest
    sys.exit(pytest.main(sys.argv[1:]))
