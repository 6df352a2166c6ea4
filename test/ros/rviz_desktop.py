"""RViz on a display of its own, with a mouse: what is seen, and where things of the world are seen."""

import math
import os
import pathlib
import signal
import subprocess
import time

import numpy as np
from PIL import Image, ImageGrab

from cloth_client import wait_for

PACKAGE = pathlib.Path(__file__).resolve().parent.parent.parent
CONFIGURATION = PACKAGE / "config/rviz/clothsim.rviz"
SCREEN = (1280, 900)

# As the configuration has them.
BACKGROUND = (48, 50, 56)
DISTANCE, PITCH, YAW = 2.5, 0.5, 0.9  # of the camera from what it looks at [m, rad]
FOCUS = np.array([0.5, 0.5, 0.45])    # [m]
FIELD_OF_VIEW = math.pi / 4           # upright, Ogre's default


class Desktop:
    def __init__(self):
        read_end, write_end = os.pipe()
        self._xvfb = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "%dx%dx24" % SCREEN, "-nolisten", "tcp"],
            pass_fds=[write_end], stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as file:
            self.display = ":" + file.readline().strip()
        self._environment = dict(os.environ, DISPLAY=self.display, LIBGL_ALWAYS_SOFTWARE="1",
                                 QT_QPA_PLATFORMTHEME="", XDG_RUNTIME_DIR="/tmp")
        self._rviz = subprocess.Popen(["rviz", "-d", str(CONFIGURATION)], env=self._environment)

    def close(self):
        for process in (self._rviz, self._xvfb):
            process.send_signal(signal.SIGTERM)
        for process in (self._rviz, self._xvfb):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def rviz_lives(self):
        return self._rviz.poll() is None

    def picture(self):
        """The screen, rows x columns x 3."""
        return np.asarray(ImageGrab.grab(xdisplay=self.display).convert("RGB")).astype(int)

    def wait_until_still(self, view):
        """Until what is seen has come to rest."""
        left, top = view.corner
        right, bottom = view.corner + view.size
        pictures = [self.picture()[top:bottom, left:right]]

        def same_again():
            time.sleep(0.5)
            pictures.append(self.picture()[top:bottom, left:right])
            return np.array_equal(pictures[-1], pictures[-2])
        wait_for(same_again, "a picture that stands still")

    def mouse(self, *commands):
        """Commands of xdotool, such as ("mousemove", 100, 200, "click", 1)."""
        subprocess.run(["xdotool"] + [str(c) for c in commands], env=self._environment, check=True)

    def press(self, place):
        self.mouse("mousemove", *place, "sleep", 0.2, "mousedown", 1)

    def drag(self, place):
        self.mouse("mousemove", *place, "sleep", 0.2)

    def release(self):
        self.mouse("mouseup", 1)

    def click(self, place):
        self.mouse("mousemove", *place, "sleep", 0.2, "click", 1)


def pixels_of(picture, color, tolerance=30):
    """x and y of all that have about that colour, N x 2."""
    rows, columns = np.nonzero((np.abs(picture - color) <= tolerance).all(axis=2))
    return np.stack([columns, rows], axis=1)


class View:
    """Of RViz's camera, as it is at the start."""

    def __init__(self, picture):
        background = pixels_of(picture, BACKGROUND, 0)
        self.corner = background.min(axis=0)
        self.size = background.max(axis=0) + 1 - self.corner
        out = np.array([math.cos(YAW) * math.cos(PITCH), math.sin(YAW) * math.cos(PITCH),
                        math.sin(PITCH)])
        self.eye = FOCUS + DISTANCE * out
        right = np.cross(-out, [0, 0, 1])
        right /= np.linalg.norm(right)
        self.axes = np.array([right, np.cross(right, -out), -out])  # right, up, ahead

    def __eq__(self, other):
        return np.array_equal(self.corner, other.corner) and np.array_equal(self.size, other.size)

    def pixel(self, point):
        """Where a point of the world is seen, and how far ahead it is [m]."""
        right, up, ahead = self.axes @ (np.asarray(point) - self.eye)
        scale = self.size[1] / 2 / math.tan(FIELD_OF_VIEW / 2)
        x, y = self.size / 2 + scale / ahead * np.array([right, -up])
        return self.corner + [x, y], ahead


def ready(desktop, shows):
    """The picture, once RViz is there and `shows` finds in it what it should show. One that does not is
    kept beside the logs."""
    pictures = []

    def look():
        assert desktop.rviz_lives(), "RViz has ended"
        pictures.append(desktop.picture())
        return len(pixels_of(pictures[-1], BACKGROUND, 0)) > 1000 and shows(pictures[-1])
    try:
        wait_for(look, "RViz to show it")
    except AssertionError:
        folder = os.environ.get("ROS_HOME", ".")
        Image.fromarray(pictures[-1].astype(np.uint8)).save(os.path.join(folder, "rviz_test.png"))
        raise
    return pictures[-1]
