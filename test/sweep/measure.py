"""A measure of a case, for the test."""

import csv


def measure(folder):
    with open(folder / "final.csv") as file:
        heights = [float(row["z"]) for row in csv.DictReader(file)]
    if min(heights) < 0.93:
        raise ValueError("it fell to %g" % min(heights))
    return {"lowest": min(heights), "span": {"z": max(heights) - min(heights)}}
