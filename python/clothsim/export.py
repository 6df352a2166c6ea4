"""A run of a cloth as files that other programs read: OBJ, PLY or USD.

    recording = clothsim.export.Recording.of(simulator)
    for _ in range(50):
        simulator.step(3)
        recording.add(simulator)
    recording.save("cloth.usda")

or from the frames.npz of `simulate`: Recording.load("out/frames.npz"). SI units, z up.
"""

import pathlib
import sys
import zipfile

import numpy as np

import clothsim

ENDINGS = (".obj", ".ply", ".usda")


class Recording:
    """The surface of a cloth over time: `triangles` [T, 3], `uv` [N, 2], and lists of `times` [s] and
    `positions` [N, 3] [m]."""

    def __init__(self, triangles, uv):
        self.triangles, self.uv = np.asarray(triangles, dtype=np.int32), np.asarray(uv)
        self.times, self.positions = [], []

    @classmethod
    def of(cls, simulator):
        """Begins with the state of a simulator as it is now."""
        topology = simulator.topology
        recording = cls(topology["triangles"], topology["uv"])
        recording.add(simulator)
        return recording

    @classmethod
    def load(cls, path):
        """From a frames.npz. Raises InvalidValue."""
        try:
            with np.load(path) as file:
                recording = cls(file["triangles"], file["uv"])
                recording.times, recording.positions = list(file["times"]), list(file["positions"])
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise clothsim.InvalidValue(f"{path}: {error}; expected a frames.npz of simulate") from None
        return recording

    def add(self, simulator):
        """The state as it is now, a copy."""
        self.times.append(simulator.time)
        self.positions.append(np.array(simulator.positions))

    def save(self, path):
        """By the ending of `path`: one .usda with all frames, or a file for each, cloth.obj as
        cloth_000000.obj and so on. Returns their paths. Raises InvalidValue."""
        path = pathlib.Path(path)
        if path.suffix not in ENDINGS:
            raise clothsim.InvalidValue(f'output: got "{path}", expected an ending of {", ".join(ENDINGS)}')
        if not self.times or len(self.triangles) == 0:
            raise clothsim.InvalidValue("frames: got a run without a surface or without frames, expected some")
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".usda":
            path.write_text(to_usda(self))
            return [path]
        to_bytes = to_obj if path.suffix == ".obj" else to_ply
        paths = []
        for number, positions in enumerate(self.positions):
            paths.append(path.with_name(f"{path.stem}_{number:06}{path.suffix}"))
            paths[-1].write_bytes(to_bytes(self, positions))
        return paths


def to_obj(recording, positions):
    """Wavefront OBJ of one frame, with texture coordinates."""
    lines = ["# clothsim: metres, z up"]
    lines += ["v %.17g %.17g %.17g" % tuple(point) for point in positions]
    lines += ["vt %.17g %.17g" % tuple(point) for point in recording.uv]
    lines += ["f %d/%d %d/%d %d/%d" % tuple(np.repeat(corners + 1, 2)) for corners in recording.triangles]
    return ("\n".join(lines) + "\n").encode()


def to_ply(recording, positions):
    """Binary PLY of one frame, byte for byte that of simulate."""
    header = ("ply\nformat binary_%s_endian 1.0\nelement vertex %d\nproperty double x\nproperty double y\n"
              "property double z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n"
              % (sys.byteorder, len(positions), len(recording.triangles)))
    faces = np.empty(len(recording.triangles), dtype=[("count", "u1"), ("corners", "i4", 3)])
    faces["count"], faces["corners"] = 3, recording.triangles
    return header.encode() + np.ascontiguousarray(positions, dtype=float).tobytes() + faces.tobytes()


def tuples(rows):
    """A list of vectors as USD writes them, in single precision."""
    return "[" + ", ".join("(" + ", ".join("%.9g" % x for x in row) + ")" for row in np.float32(rows)) + "]"


def to_usda(recording):
    """One Mesh with points that change over time, in the text form of OpenUSD: Debian packages no
    library of it. Time codes are frames at the rate of the first two."""
    times = np.asarray(recording.times)
    rate = 1 / (times[1] - times[0]) if len(times) > 1 else 1.0
    codes = ["%.9g" % code for code in np.round(times * rate, 6)]
    points = ["        %s: %s," % (code, tuples(x)) for code, x in zip(codes, recording.positions)]
    extents = ["        %s: %s," % (code, tuples([x.min(axis=0), x.max(axis=0)]))
               for code, x in zip(codes, recording.positions)]
    corners = ", ".join(map(str, recording.triangles.ravel()))
    return "\n".join([
        "#usda 1.0", "(", '    defaultPrim = "cloth"', "    startTimeCode = " + codes[0],
        "    endTimeCode = " + codes[-1], "    timeCodesPerSecond = %.9g" % rate,
        "    metersPerUnit = 1", '    upAxis = "Z"', ")", "", 'def Mesh "cloth"', "{",
        '    uniform token subdivisionScheme = "none"', "    uniform bool doubleSided = 1",
        "    int[] faceVertexCounts = [" + ", ".join(["3"] * len(recording.triangles)) + "]",
        "    int[] faceVertexIndices = [" + corners + "]",
        "    texCoord2f[] primvars:st = " + tuples(recording.uv) + " (",
        '        interpolation = "vertex"', "    )",
        "    float3[] extent.timeSamples = {", *extents, "    }",
        "    point3f[] points.timeSamples = {", *points, "    }", "}", ""])
