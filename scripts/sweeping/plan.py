"""Reads a sweep and makes its table of cases."""

import hashlib
import itertools
import json
import math
import pathlib

import yaml

MOST_CASES = 1_000_000
VIEW = "view."  # prefix of the keys of the view; all others are keys of the scene
DRAWN = ("random", "log_random", "latin", "log_latin")
SPACED = ("range", "log_range")
KINDS = ("list", *SPACED, *DRAWN, "choices")


class BadSweep(Exception):
    """An invalid value in a sweep file: key, got, expected."""

    def __init__(self, key, got, expected):
        super().__init__("%s: got %s, expected %s" % (key, got, expected))


def shown(value):
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


def number(key, value):
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value):
        raise BadSweep(key, shown(value), "a finite number")
    return float(value)


def whole(key, value, least):
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= MOST_CASES:
        raise BadSweep(key, shown(value), "a whole number from %d to %d" % (least, MOST_CASES))
    return value


def check_keys(key, value, known):
    if not isinstance(value, dict):
        raise BadSweep(key, shown(value), "a map")
    for name in value:
        if name not in known:
            raise BadSweep("%s.%s" % (key, name), "an unknown key", "one of " + ", ".join(known))


class Axis:
    """One column of the case table, and the values of scene and view that it sets."""

    def __init__(self, name, spec):
        key = "axes." + name
        if isinstance(spec, list):
            spec = {"list": spec}
        check_keys(key, spec, (*KINDS, "count", "keys"))
        kinds = [kind for kind in KINDS if kind in spec]
        if len(kinds) != 1:
            raise BadSweep(key, ", ".join(kinds) or "none of them", "one of " + ", ".join(KINDS))
        self.name, self.kind, self.spec = name, kinds[0], spec[kinds[0]]
        key += "." + self.kind
        self.bounds = self.values = None
        if self.kind == "list":
            if not isinstance(self.spec, list) or not self.spec:
                raise BadSweep(key, shown(self.spec), "a list of values")
            self.values = self.spec
        elif self.kind == "choices":
            if not isinstance(self.spec, dict) or not self.spec or not all(
                    isinstance(values, dict) for values in self.spec.values()):
                raise BadSweep(key, shown(self.spec), "names, each with a map of keys and values")
            self.values = list(self.spec)
        else:
            self.bounds = self.read_bounds(key)
            if self.kind in SPACED:
                count = whole("axes.%s.count" % name, spec.get("count"), 2)
                self.values = [self.place(i / (count - 1)) for i in range(count)]
        if "count" in spec and self.kind not in SPACED:
            raise BadSweep("axes.%s.count" % name, shown(spec["count"]), "none beside " + self.kind)
        self.keys = self.read_keys(name, spec.get("keys"))

    def read_bounds(self, key):
        if not isinstance(self.spec, list) or len(self.spec) != 2:
            raise BadSweep(key, shown(self.spec), "[first, last]")
        first, last = (number(key, value) for value in self.spec)
        if self.kind.startswith("log") and not (first > 0 and last > 0):
            raise BadSweep(key, shown(self.spec), "two numbers above 0")
        return first, last

    def read_keys(self, name, keys):
        """The keys that the axis sets, each with a factor; without `keys`, the key of the axis's name."""
        if self.kind == "choices":
            if keys is not None:
                raise BadSweep("axes.%s.keys" % name, shown(keys), "none beside choices")
            return {}
        if keys is None:
            return {name: 1}
        if isinstance(keys, list) and keys:
            return {str(key): 1 for key in keys}
        if isinstance(keys, dict) and keys:
            return {str(key): number("axes.%s.keys.%s" % (name, key), factor)
                    for key, factor in keys.items()}
        raise BadSweep("axes.%s.keys" % name, shown(keys), "a list of keys, or a map of keys and factors")

    def place(self, share):
        """The value at a share from 0 to 1 of the way between the bounds."""
        first, last = self.bounds
        if share in (0, 1):
            return last if share else first
        if self.kind.startswith("log"):
            return first * (last / first) ** share
        return first + share * (last - first)

    def all_keys(self):
        if self.kind == "choices":
            return {str(key) for values in self.spec.values() for key in values}
        return set(self.keys)

    def settings(self, value):
        if self.kind == "choices":
            return {str(key): own for key, own in self.spec[value].items()}
        return {key: value if factor == 1 else value * factor for key, factor in self.keys.items()}


class Plan:
    """A sweep with the settings of each case. Equal files give equal plans."""

    KEYS = ("scene", "seconds", "every", "from", "set", "axes", "samples", "seed", "measure",
            "view", "video")

    def __init__(self, path):
        self.path = pathlib.Path(path).resolve()
        sweep = read_yaml(self.path)
        check_keys(str(path), sweep, self.KEYS)
        self.folder = self.path.parent
        if "scene" not in sweep:
            raise BadSweep("scene", "nothing", "a scene file")
        self.scene = self.file("scene", sweep["scene"])
        self.start = self.file("from", sweep["from"]) if "from" in sweep else None
        self.measure = self.file("measure", sweep["measure"]) if "measure" in sweep else None
        self.view = self.file("view", sweep["view"]) if "view" in sweep else None
        self.video = sweep.get("video", False)
        if not isinstance(self.video, bool):
            raise BadSweep("video", shown(self.video), "true or false")
        self.times = {name: number(name, sweep[name]) for name in ("seconds", "every") if name in sweep}
        common = sweep.get("set", {})
        if not isinstance(common, dict):
            raise BadSweep("set", shown(common), "a map of keys and values")
        self.common = {str(key): value for key, value in common.items()}
        axes = sweep.get("axes")
        if not isinstance(axes, dict) or not axes:
            raise BadSweep("axes", shown(axes), "a map of keys and their values")
        self.axes = [Axis(str(name), spec) for name, spec in axes.items()]
        self.seed = whole("seed", sweep.get("seed", 1), 0)
        self.cases = self.make_cases(sweep.get("samples"))
        self.sweep = sweep

    def file(self, key, name):
        path = self.folder / str(name)
        if not path.is_file():
            raise BadSweep(key, shown(str(name)), "a file, as seen from " + str(self.folder))
        return path

    def make_cases(self, samples):
        """The value of each axis in each case: the grid of the listed axes, crossed with one design of the
        random axes."""
        grid = [axis for axis in self.axes if axis.values is not None]
        drawn = [axis for axis in self.axes if axis.values is None]
        if not drawn and samples is not None:
            raise BadSweep("samples", shown(samples), "none, as no axis is drawn")
        count = whole("samples", samples, 1) if drawn else 1
        total = count * math.prod(len(axis.values) for axis in grid)
        if total > MOST_CASES:
            raise BadSweep("axes", "%d cases" % total, "at most %d" % MOST_CASES)
        design = self.draw(drawn, count)
        cases = []
        for values in itertools.product(*(axis.values for axis in grid)):
            for sample in design:
                case = {**dict(zip((axis.name for axis in grid), values)), **sample}
                cases.append({axis.name: case[axis.name] for axis in self.axes})
        return cases

    def draw(self, axes, count):
        """`count` samples of the axes, jointly for Latin hypercubes, independently for the others."""
        if not axes:
            return [{}]
        import numpy as np  # imported here, as it takes a second and most sweeps do not need it
        from scipy.stats import qmc
        latin = [axis for axis in axes if axis.kind.endswith("latin")]
        plain = [axis for axis in axes if axis not in latin]
        shares = {}
        if plain:
            drawn = np.random.default_rng(self.seed).random((count, len(plain)))
            shares.update({axis.name: drawn[:, i] for i, axis in enumerate(plain)})
        if latin:
            drawn = qmc.LatinHypercube(len(latin), seed=self.seed).random(count)
            shares.update({axis.name: drawn[:, i] for i, axis in enumerate(latin)})
        return [{axis.name: axis.place(float(shares[axis.name][i])) for axis in axes}
                for i in range(count)]

    def draws(self):
        """Whether cases are drawn: the sweep names a view, a key of the view or a video."""
        keys = {*self.common}.union(*(axis.all_keys() for axis in self.axes))
        return bool(self.view or self.video or any(key.startswith(VIEW) for key in keys))

    def settings(self, number):
        """Keys of scene and view, and their values in a case."""
        settings = dict(self.common)
        for axis in self.axes:
            settings.update(axis.settings(self.cases[number][axis.name]))
        return settings

    def fingerprint(self):
        """A hash of everything that results depend on; a sweep with another hash is another sweep."""
        digest = hashlib.sha256(json.dumps(self.sweep, sort_keys=True, default=str).encode())
        for path in (self.scene, self.start, self.measure, self.view):
            digest.update(path.read_bytes() if path else b"")
        return digest.hexdigest()


def read_yaml(path):
    try:
        return yaml.safe_load(path.read_text())
    except OSError as error:
        raise BadSweep(str(path), error.strerror, "a sweep file (YAML)") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BadSweep(str(path), str(error).replace("\n", " "), "YAML") from error
