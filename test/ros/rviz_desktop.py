"""RViz on a display of its own, with a mouse: its pictures, and the pixels of points of the world."""

import math
import os
import pathlib
import signal
import subprocess
import tempfile
import time

import numpy as np
from PIL import Image, ImageGrab

from cloth_client import wait_for

PACKAGE = pathlib.Path(__file__).resolve().parent.parent.parent
CONFIGURATION = PACKAGE / "config/rviz/clothsim.rviz"
SCREEN = (1280, 900)

# As in the configuration.
BACKGROUND = (48, 50, 56)
DISTANCE, PITCH, YAW = 2.5, 0.5, 0.9  # of the camera from its focal point [m, rad]
FOCUS = np.array([0.5, 0.5, 0.45])    # [m]
FIELD_OF_VIEW = math.pi / 4           # upright, Ogre's default

TITLE = (184, 184, 184)  # of a panel


class Desktop:
    def __init__(self, looks_at_scenes=False):
        """RViz as the launch files start it; its camera turns to new scenes, or stays where it is."""
        read_end, write_end = os.pipe()
        self._xvfb = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "%dx%dx24" % SCREEN, "-nolisten", "tcp"],
            pass_fds=[write_end], stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as file:
            self.display = ":" + file.readline().strip()
        self._environment = dict(os.environ, DISPLAY=self.display, LIBGL_ALWAYS_SOFTWARE="1",
                                 QT_QPA_PLATFORMTHEME="", XDG_RUNTIME_DIR="/tmp")
        self._folder = tempfile.TemporaryDirectory()
        configuration = pathlib.Path(self._folder.name) / "test.rviz"
        configuration.write_text(CONFIGURATION.read_text().replace(
            "Look at New Scenes: true", "Look at New Scenes: %s" % str(looks_at_scenes).lower()))
        self._rviz = subprocess.Popen(["rviz", "-d", str(configuration)], env=self._environment)

    def close(self):
        for process in (self._rviz, self._xvfb):
            process.send_signal(signal.SIGTERM)
        for process in (self._rviz, self._xvfb):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._folder.cleanup()

    def rviz_lives(self):
        return self._rviz.poll() is None

    def picture(self):
        """The screen, rows x columns x 3."""
        return np.asarray(ImageGrab.grab(xdisplay=self.display).convert("RGB")).astype(int)

    def wait_until_still(self, view):
        """Waits until the picture stays the same."""
        left, top = view.corner
        right, bottom = view.corner + view.size
        pictures = [self.picture()[top:bottom, left:right]]

        def same_again():
            time.sleep(0.5)
            pictures.append(self.picture()[top:bottom, left:right])
            return np.array_equal(pictures[-1], pictures[-2])
        wait_for(same_again, "a picture that stands still")

    def settled(self, shows):
        """The picture after the layout of the panels: the window is laid out again as they fill."""
        pictures = [ready(self, shows)]

        def same_again():
            time.sleep(0.5)
            pictures.append(ready(self, shows))
            return View(pictures[-1]) == View(pictures[-2])
        wait_for(same_again, "panels that stay where they are")
        return pictures[-1]

    @staticmethod
    def panel_top(picture):
        """Row of the upper edge of the panel, whose title is the lower grey band."""
        rows = np.flatnonzero((picture[:, 200:300] == TITLE).all(axis=(1, 2)))
        return rows[np.flatnonzero(np.diff(rows) > 1)[-1] + 1]

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
    """x and y of all pixels of about that colour, N x 2."""
    rows, columns = np.nonzero((np.abs(picture - color) <= tolerance).all(axis=2))
    return np.stack([columns, rows], axis=1)


def cloth_in(picture):
    """Mask of the pixels of the red cloth, in any light."""
    red, green, blue = np.moveaxis(picture, 2, 0)
    return (red > 60) & (red > 2 * green) & (red > 2 * blue)


def shows_cloth(picture):
    return cloth_in(picture).sum() > 5000


class View:
    """The axes of RViz's camera at the start."""

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
        """Pixel of a point of the world, and its distance ahead [m]."""
        right, up, ahead = self.axes @ (np.asarray(point) - self.eye)
        scale = self.size[1] / 2 / math.tan(FIELD_OF_VIEW / 2)
        x, y = self.size / 2 + scale / ahead * np.array([right, -up])
        return self.corner + [x, y], ahead


def ready(desktop, shows):
    """The picture, once RViz is there and `shows` accepts it. A picture that is never accepted is kept
    beside the logs."""
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
