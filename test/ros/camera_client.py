"""Shared by the tests of the node's images: subscribing, pictures as arrays, diagnostics."""

import unittest

import numpy as np
from cv_bridge import CvBridge
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image

from cloth_client import PATIENCE, Cloth, Recorder, wait_for

KINDS = {"color": "rgb8", "depth": "32FC1", "mask": "mono8"}
MORE_KINDS = {"uv": "32FC2", "normals": "32FC3", "flow": "32FC2"}


class Frame:
    """Images of one stamp, color, depth, mask and so on, each with its camera_info."""

    def __init__(self, images, infos):
        self.images, self.infos = images, infos
        for kind, image in images.items():
            setattr(self, kind, CvBridge().imgmsg_to_cv2(image, image.encoding))


class Camera:
    """The image topics of a camera of a clothsim node."""

    def __init__(self, name="/clothsim", kinds=KINDS, camera="camera"):
        topic = name + "/" + camera + "/%s/%s"
        self._images = {k: Recorder(topic % (k, "image_raw"), Image) for k in kinds}
        self._infos = {k: Recorder(topic % (k, "camera_info"), CameraInfo) for k in kinds}

    def _recorders(self):
        return [*self._images.values(), *self._infos.values()]

    def clear(self):
        for recorder in self._recorders():
            recorder.clear()

    def close(self):
        for recorder in self._recorders():
            recorder.close()

    def wait_for_connections(self):
        wait_for(lambda: all(r.connected() for r in self._recorders()), "the image topics")

    def stamps(self):
        """Stamps of the colour images, in order, each once."""
        return sorted({m.header.stamp for m in self._images["color"].all()})

    def wait_for_frame_after(self, stamp):
        """Waits until all topics have a newer message."""
        for recorder in self._recorders():
            recorder.wait("a newer image", lambda m: m.header.stamp > stamp)

    def frame(self, stamp):
        """The pictures of that stamp, waiting for them."""
        def at(recorders, what):
            return {k: r.wait("%s %s at %s" % (k, what, stamp), lambda m: m.header.stamp == stamp)
                    for k, r in recorders.items()}
        return Frame(at(self._images, "image"), at(self._infos, "camera_info"))

    def color(self, what, condition):
        """The newest colour image, as an array, for which the condition holds."""
        def array(message):
            return CvBridge().imgmsg_to_cv2(message, "rgb8")
        return array(self._images["color"].wait(what, lambda m: condition(array(m))))


class Status:
    def __init__(self, message):
        self.level, self.message = message.level, message.message
        self.values = {v.key: v.value for v in message.values}


class CameraDiagnostics:
    """The node's status of a camera in /diagnostics."""

    def __init__(self, name="clothsim", camera="camera"):
        self._name = name + ": " + camera
        self._recorder = Recorder("/diagnostics", DiagnosticArray)

    def next(self, condition=lambda status: True, what="of the camera"):
        """A status from now on for which the condition holds. The first one may have been sent before
        the call."""
        def statuses():
            return [Status(s) for array in self._recorder.all() for s in array.status
                    if s.name == self._name]

        self._recorder.clear()
        return wait_for(lambda: next((s for s in statuses() if condition(s)), None),
                        "diagnostics " + what)

    def drawn(self):
        """Number of pictures that the node has drawn."""
        self.next()
        return int(self.next().values["pictures drawn"])


def edges(mask):
    """Pixels with a neighbour of another id."""
    grown = np.pad(mask, 1, mode="edge")
    rows, columns = mask.shape
    return np.any([grown[1 + dy:1 + dy + rows, 1 + dx:1 + dx + columns] != mask
                   for dy in (-1, 0, 1) for dx in (-1, 0, 1)], axis=0)


class CameraTestCase(unittest.TestCase):
    """Each test starts at the scene's start, paused, with the values of the launch file."""

    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.diagnostics = CameraDiagnostics()
        cls.log = Recorder("/rosout", Log)
        cls.shading = Client("/clothsim/shading/cloth", timeout=PATIENCE)
        cls.sphere_shading = Client("/clothsim/shading/sphere", timeout=PATIENCE)
        cls.light = Client("/clothsim/light", timeout=PATIENCE)
        cls.viewpoint = Client("/clothsim/viewpoint", timeout=PATIENCE)
        cls.clients = [cls.shading, cls.sphere_shading, cls.light, cls.viewpoint]
        cls.start = [c.get_configuration(timeout=PATIENCE) for c in cls.clients]
        cls.start = [{k: v for k, v in c.items() if k != "groups"} for c in cls.start]

    def setUp(self):
        self.cloth.pause()
        for client, start in zip(self.clients, self.start):
            client.update_configuration(start)
        self.cloth.reset()
        self.camera = None

    def tearDown(self):
        if self.camera:
            self.camera.close()

    def subscribe(self, kinds=KINDS):
        self.camera = Camera(kinds=kinds)
        self.camera.wait_for_connections()

    def step(self, frames):
        """The state after some frames and the pictures of its stamp."""
        state = self.cloth.step(frames)
        return state, self.camera.frame(state.header.stamp)
