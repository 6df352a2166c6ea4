"""A fabric is recovered from a synthetic measurement of it, from markers and from point clouds."""

import csv

import numpy as np
import pytest
from scenes import CLONE


@pytest.fixture
def fit_fabric(monkeypatch):
    monkeypatch.syspath_prepend(CLONE / "scripts/examples")
    import fit_fabric
    return fit_fabric


def write_csv(path, measured):
    header = ["time", "x", "y", "z"] if measured.uv is None else ["time", "u", "v", "x", "y", "z"]
    parts = [measured.times[:, None], measured.points]
    if measured.uv is not None:
        parts.insert(1, measured.uv)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(np.hstack(parts).tolist())
        writer.writerow([2.0] + [""] * (len(header) - 1))  # a marker that was not seen


@pytest.mark.parametrize("kind", ["markers", "cloud"])
def test_the_values_are_found_within_a_tenth(fit_fabric, tmp_path, kind):
    write_csv(tmp_path / "measured.csv", fit_fabric.made_up(kind))
    values, spreads = fit_fabric.fit(fit_fabric.Measurement.load(tmp_path / "measured.csv"))
    sought = [name for name in fit_fabric.TRUTH if kind == "markers" or name != "stretch_stiffness"]
    assert list(values) == sought
    for name in sought:
        truth, guess = fit_fabric.TRUTH[name], fit_fabric.SOUGHT[name][1]
        assert max(guess / truth, truth / guess) > 1.5, name
        assert values[name] == pytest.approx(truth, rel=0.1), name
        assert 0 < spreads[name] < 0.1 * truth, name


def test_files_of_both_kinds_say_the_same(fit_fabric, tmp_path):
    measured = fit_fabric.made_up()
    write_csv(tmp_path / "measured.csv", measured)
    times = np.unique(measured.times)
    positions = measured.points.reshape(len(times), -1, 3).copy()
    positions[3, 2] = np.nan  # not seen
    np.savez(tmp_path / "measured.npz", times=times, positions=positions,
             uv=measured.uv.reshape(len(times), -1, 2)[0])
    by_csv = fit_fabric.Measurement.load(tmp_path / "measured.csv")
    by_npz = fit_fabric.Measurement.load(tmp_path / "measured.npz")
    assert np.array_equal(by_csv.points, measured.points) and np.array_equal(by_csv.uv, measured.uv)
    assert len(by_npz.points) == len(by_csv.points) - 1
    errors = fit_fabric.Model().residual(fit_fabric.TRUTH, by_npz)
    assert np.sqrt(np.mean(errors ** 2)) == pytest.approx(fit_fabric.NOISE, rel=0.05)


def test_a_file_of_something_else_is_told(fit_fabric, tmp_path):
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(SystemExit, match="time,x,y,z"):
        fit_fabric.Measurement.load(tmp_path / "other.csv")
