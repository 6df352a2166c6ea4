"""One table of parameters and results, and plots of its columns."""

import csv
import io
import json
import math
import os

import h5py
import numpy as np

from sweeping.cases import write_whole

FIRST = ("case", "status", "message", "case_seconds")


def gather(store, numbers):
    """Rows of the cases, in order, and the names of all columns."""
    rows = []
    for number in sorted(numbers):
        result = store.result(number)
        row = {name: result.get(name, "") for name in FIRST}
        row.update({key: value if isinstance(value, (int, float, str)) else json.dumps(value)
                    for key, value in result["parameters"].items()})
        row.update({key if key not in row else "report." + key: value
                    for key, value in result["results"].items()})
        rows.append(row)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    return rows, columns


def column(rows, name):
    """An array of numbers, with nan where there is none, or of texts."""
    values = [row.get(name) for row in rows]
    if all(value is None or isinstance(value, (bool, int, float)) for value in values):
        return np.array([math.nan if value is None else float(value) for value in values])
    return np.array(["" if value is None else str(value) for value in values], dtype=object)


def write_table(folder, rows, columns):
    """results.csv, and results.h5 with one data set a column."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_whole(folder / "results.csv", text.getvalue())
    part = folder / (".results.h5.%d.part" % os.getpid())
    with h5py.File(part, "w") as file:
        for name in columns:
            values = column(rows, name)
            kind = h5py.string_dtype() if values.dtype == object else None
            file.create_dataset(name.replace("/", "_"), data=values, dtype=kind)
    part.rename(folder / "results.h5")


def plot(folder, rows, columns, names):
    """A picture of y over x, or of z over x and y."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    for name in names:
        if name not in columns:
            raise SystemExit("sweep: --plot: got %s, expected one of %s" % (name, ", ".join(columns)))
    values = [column(rows, name) for name in names]
    figure, axes = plt.subplots(figsize=(6, 4.5))
    axes.set(xlabel=names[0], ylabel=names[1])
    if len(names) == 2:
        axes.plot(values[0], values[1], "o", markersize=4)
    else:
        draw_map(figure, axes, values, names[2])
    path = folder / ("plot_%s.png" % "_".join(names).replace("/", "_"))
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)
    return path


def draw_map(figure, axes, values, label):
    """Cells where x and y make a grid, else points."""
    x, y, z = values
    texts = None
    if z.dtype == object:
        texts, z = np.unique(z, return_inverse=True)
    xs, ys = np.unique(x), np.unique(y)
    if len(xs) * len(ys) == len(z) and min(len(xs), len(ys)) > 1:
        grid = np.full((len(ys), len(xs)), np.nan)
        grid[np.searchsorted(ys, y), np.searchsorted(xs, x)] = z
        drawn = axes.pcolormesh(np.arange(len(xs) + 1), np.arange(len(ys) + 1), grid)
        axes.set_xticks(np.arange(len(xs)) + 0.5, ["%.3g" % v if x.dtype != object else v for v in xs])
        axes.set_yticks(np.arange(len(ys)) + 0.5, ["%.3g" % v if y.dtype != object else v for v in ys])
    else:
        drawn = axes.scatter(x, y, c=z)
    bar = figure.colorbar(drawn, label=label)
    if texts is not None:
        bar.set_ticks(range(len(texts)), labels=texts)
