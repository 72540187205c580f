"""Stand-ins for packages that only references need: a test that uses an absent one is skipped."""

import importlib.util
import os
import sys
from types import ModuleType

import pytest

PACKAGES = ("jsonschema", "mpmath")
OPERATIONS = ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv", "pow", "rpow",
              "neg", "pos", "abs", "float", "int", "lt", "le", "gt", "ge", "getitem", "iter",
              "call",
              "enter", "exit")


class Absent(ModuleType):
    """What an absent package has. Modules may use it as they are imported: constants of theirs are
    absent, too."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return use(self)


def use(absent, *_, **__):
    if "PYTEST_CURRENT_TEST" in os.environ:
        pytest.skip(f"{absent.__name__} is not installed")
    return absent


for operation in OPERATIONS:
    setattr(Absent, f"__{operation}__", use)


def stand_in(packages=PACKAGES):
    for name in packages:
        if (name in sys.modules and not sys.modules[name]) or not importlib.util.find_spec(name):
            sys.modules[name] = Absent(name)
