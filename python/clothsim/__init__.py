"""Cloth, simulated in this process: see docs/python.md. SI units, z up.

    import clothsim
    simulator = clothsim.Simulator("config/scenes/sphere.yaml")
    simulator.step(90)
    print(simulator.positions)

The messages of the node, `clothsim.msg` and `clothsim.srv`, are in this package too where ROS is.
"""

import importlib

_MODULES = {
    "_core": ("Batch", "Body", "Cloth", "Diverged", "InvalidValue", "Robot", "SavedState", "Scene", "Simulator",
              "StepReport", "__version__"),
    "_render": ("View",),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [name for name in _HOME if not name.startswith("_")]


def __getattr__(name):
    """Loads the simulator on its first use: programs that only need messages do not wait for it."""
    if name not in _HOME:
        raise AttributeError(f"module 'clothsim' has no attribute {name!r}")
    value = getattr(importlib.import_module("clothsim." + _HOME[name]), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_HOME})
