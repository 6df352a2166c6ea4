#!/usr/bin/python3
"""The node's images: their content, their times, and their view."""

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from image_geometry import PinholeCameraModel
import tf2_ros

from clothsim.msg import VisiblePoints
from camera_client import KINDS, MORE_KINDS, CameraTestCase, edges
from cloth_client import Recorder, make_transform, point, positions, wait_for

WIDTH, HEIGHT = 320, 240
K = [520, 0, 140.25, 0, 450, 126.5, 0, 0, 1]
EYE = np.array([1.9, -1.5, 2.2])  # [m]
TARGET = np.array([0.5, 0.5, 0.55])  # [m]
NOTHING, CLOTH, SPHERE = 0, 1, 2
SPHERE_CENTRE, SPHERE_RADIUS = np.array([0.5, 0.5, 0.2]), 0.2  # [m]
OWN_FRAME = "clothsim_camera_optical"


def axes(eye, target):
    """Right, down and forward of a camera that looks from eye to target, as columns."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(forward, right), forward])


def quaternion(rotation):
    """x, y, z, w of a rotation matrix."""
    values, vectors = np.linalg.eigh(np.array([
        [rotation[0, 0] - rotation[1, 1] - rotation[2, 2], 0, 0, 0],
        [rotation[1, 0] + rotation[0, 1], rotation[1, 1] - rotation[0, 0] - rotation[2, 2], 0, 0],
        [rotation[2, 0] + rotation[0, 2], rotation[2, 1] + rotation[1, 2],
         rotation[2, 2] - rotation[0, 0] - rotation[1, 1], 0],
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
         rotation[1, 0] - rotation[0, 1], np.trace(rotation)]]))
    return vectors[:, values.argmax()]


def model(info):
    camera = PinholeCameraModel()
    camera.fromCameraInfo(info)
    return camera


def project(camera, points, eye=EYE, target=TARGET):
    """Pixels (N x 2) by image_geometry, and distances along z [m]."""
    local = (points - eye) @ axes(eye, target)
    return np.array([camera.project3dToPixel(p) for p in local]), local[:, 2]

class CameraTest(CameraTestCase):
    # ---- Content of an image ----

    def test_messages(self):
        self.subscribe()
        state, frame = self.step(3)
        bytes_per_pixel = {"color": 3, "depth": 4, "mask": 1}
        for kind, encoding in KINDS.items():
            image, info = frame.images[kind], frame.infos[kind]
            self.assertEqual(image.encoding, encoding)
            self.assertEqual((image.width, image.height), (WIDTH, HEIGHT))
            self.assertEqual(image.step, WIDTH * bytes_per_pixel[kind])
            self.assertEqual(len(image.data), HEIGHT * image.step)
            self.assertEqual(image.is_bigendian, 0)
            self.assertEqual(image.header.stamp, state.header.stamp)
            self.assertEqual(image.header.frame_id, OWN_FRAME)
            self.assertEqual((info.header.stamp, info.header.frame_id),
                             (image.header.stamp, image.header.frame_id))
            self.assertEqual((info.width, info.height), (WIDTH, HEIGHT))
            self.assertEqual(list(info.K), K)
            self.assertEqual(list(info.P), K[:3] + [0] + K[3:6] + [0] + K[6:] + [0])
            self.assertEqual(list(info.R), [1, 0, 0, 0, 1, 0, 0, 0, 1])
            self.assertEqual(info.distortion_model, "plumb_bob")
            self.assertEqual(list(info.D), [0] * 5)

    def test_tf_knows_the_optical_frame(self):
        """Without subscribers to images, and also after the camera has moved."""
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)

        def pose():
            if not buffer.can_transform("map", OWN_FRAME, rospy.Time(0)):
                return None
            t = buffer.lookup_transform("map", OWN_FRAME, rospy.Time(0)).transform
            return (point(t.translation),
                    np.array([t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w]))
        for eye in (EYE, EYE + [0, 0, 1]):
            self.viewpoint.update_configuration({"eye_z": eye[2]})
            wait_for(lambda e=eye: pose() and np.allclose(pose()[0], e), "the camera's frame")
            self.assertAlmostEqual(abs(pose()[1] @ quaternion(axes(eye, TARGET))), 1, delta=1e-9)
        listener.unregister()

    def agreement(self, state, frame):
        """Share of the state's points that depth and mask show at their projection by image_geometry, or
        hidden by a nearer object; and share of the mask's cloth that is near one of these points."""
        # Without points on the rim, which lie on the edge of a pixel as often as not.
        points = positions(state).astype(float).reshape(50, 50, 3)[1:-1, 1:-1].reshape(-1, 3)
        pixels, distance = project(model(frame.infos["mask"]), points)
        columns, rows = np.rint(pixels).astype(int).T
        seen = (columns >= 0) & (columns < WIDTH) & (rows >= 0) & (rows < HEIGHT)
        columns, rows, distance = columns[seen], rows[seen], distance[seen]
        self.assertGreater(len(rows), 1000)

        # Cloth that is seen edge on is this much farther away at a distance of half a pixel [m].
        slack = 0.03
        depth, mask = frame.depth[rows, columns], frame.mask[rows, columns]
        at_place = (mask == CLOTH) & (np.abs(distance - depth) < slack)
        hidden = (mask != NOTHING) & (distance > depth)

        # Neighbours are up to 4 pixels apart, and the rim as far from the outermost.
        near = np.zeros((HEIGHT + 10, WIDTH + 10), bool)
        for dy in range(11):
            for dx in range(11):
                near[rows + dy, columns + dx] = True
        return np.mean(at_place | hidden), np.mean(near[5:-5, 5:-5][frame.mask == CLOTH])

    def check_frame(self, frame):
        """Colour, depth and mask show one state: the red cloth is red wherever the mask says that
        it is cloth, and nowhere else."""
        self.assertTrue(np.array_equal(np.isinf(frame.depth), frame.mask == NOTHING))
        red = (frame.color[..., 0] > 40) & (frame.color[..., 1] < 10)
        clear = ~edges(frame.mask)
        self.assertGreater(np.sum(red), 1000)
        self.assertTrue(np.array_equal(red[clear], (frame.mask == CLOTH)[clear]))

    def use_clear_colors(self):
        """No red sphere, no dark cloth: ambient light reaches folds that turn away from the lamp."""
        self.light.update_configuration({"ambient": 0.5})
        self.shading.update_configuration({"shader": "blinn_phong", "ks": 0.0})
        self.sphere_shading.update_configuration({"color_r": 0.0, "ks": 0.0})

    def check_shown(self, states, frames):
        """Each frame shows its own state and not the one before, while the cloth moves."""
        for state, frame, before in zip(states[1:], frames[1:], states):
            self.check_frame(frame)
            for share in self.agreement(state, frame):
                self.assertGreater(share, 0.98)
            self.assertLess(min(self.agreement(before, frame)), 0.96)

    def test_images_show_the_state_of_their_stamp(self):
        self.use_clear_colors()
        self.subscribe()
        self.cloth.step(16)
        self.check_shown(*zip(*[self.step(6) for _ in range(6)]))

    def pictures_of_a_fall(self):
        """States and pictures of the fall, each of a stamp, from one run of the node. Later frames, which
        pass while a busy machine draws, have folds that `agreement` does not know."""
        self.cloth.reset()
        self.step(16)  # and its picture, so that none is on its way
        self.camera.clear()
        self.cloth.states.clear()
        self.cloth.pause(False)
        wait_for(lambda: len(self.cloth.states.all()) > 30, "states of a running simulation")
        self.cloth.pause()
        fall = {s.header.stamp: s for s in self.cloth.states.all()[:30]}
        self.step(1)  # its picture comes after all others
        stamps = [stamp for stamp in self.camera.stamps() if stamp in fall]
        return [fall[s] for s in stamps], [self.camera.frame(s) for s in stamps]

    def test_images_of_a_running_simulation_show_one_state(self):
        self.use_clear_colors()
        self.subscribe()
        shown = 0
        while shown < 4:
            states, frames = self.pictures_of_a_fall()
            self.check_shown(states, frames)
            shown += len(frames[1:])

    def test_depth_of_the_sphere(self):
        self.subscribe()
        _, frame = self.step(1)  # the cloth is still far above
        camera = model(frame.infos["depth"])
        rows, columns = np.nonzero((frame.mask == SPHERE) & ~edges(frame.mask))
        self.assertGreater(len(rows), 50)
        for row, column in zip(rows, columns):
            ray = np.array(camera.projectPixelTo3dRay((column, row)))
            ray = axes(EYE, TARGET) @ (ray / ray[2])
            # |eye + z ray - centre| = radius, nearer solution
            a, offset = ray @ ray, EYE - SPHERE_CENTRE
            b, c = ray @ offset, offset @ offset - SPHERE_RADIUS ** 2
            z = (-b - np.sqrt(b * b - a * c)) / a
            self.assertAlmostEqual(frame.depth[row, column], z, delta=1e-4)

    def seen_points(self, state, frame):
        """Points of the cloth's grid that are visible by depth: their numbers, rows and columns of pixels."""
        pixels, distance = project(model(frame.infos["depth"]), positions(state).astype(float))
        columns, rows = np.rint(pixels).astype(int).T
        at = np.flatnonzero((columns >= 0) & (columns < WIDTH) & (rows >= 0) & (rows < HEIGHT))
        at = at[frame.mask[rows[at], columns[at]] == CLOTH]
        at = at[np.abs(frame.depth[rows[at], columns[at]] - distance[at]) < 0.01]
        self.assertGreater(len(at), 1000)
        return at, rows[at], columns[at]

    def test_more_images(self):
        """The form of each image, and that it belongs to the state of its stamp."""
        self.subscribe({**KINDS, **MORE_KINDS})
        self.cloth.step(29)
        before, frame_before = self.step(1)
        state, frame = self.step(1)
        for kind, encoding in MORE_KINDS.items():
            image = frame.images[kind]
            self.assertEqual((image.encoding, image.width, image.height), (encoding, WIDTH, HEIGHT))
            self.assertEqual(image.step, WIDTH * 4 * int(encoding[-1]))
            for header in (image.header, frame.infos[kind].header):
                self.assertEqual((header.stamp, header.frame_id), (state.header.stamp, OWN_FRAME))
            self.assertEqual(list(frame.infos[kind].K), K)
        self.assertTrue(np.array_equal(np.isnan(frame.uv[..., 0]), frame.mask != CLOTH))
        points, rows, columns = self.seen_points(state, frame)
        uv = np.column_stack([points % 50, points // 50]) / 49
        # Half a pixel of the cloth seen at a slant.
        self.assertLess(np.abs(frame.uv[rows, columns] - uv).max(), 0.02)
        # The sphere stands still; the flow of the cloth is the difference of its projections by image_geometry.
        self.assertTrue(np.array_equal(np.isnan(frame.flow[..., 0]), frame.mask == NOTHING))
        self.assertLess(np.abs(frame.flow[frame.mask == SPHERE]).max(), 1e-3)
        camera = model(frame_before.infos["flow"])
        moved = (project(camera, positions(state).astype(float)[points])[0]
                 - project(camera, positions(before).astype(float)[points])[0])
        self.assertGreater(np.linalg.norm(moved, axis=1).max(), 1)
        self.assertLess(np.abs(frame.flow[rows, columns] - moved).max(), 0.2)
        # A sphere's normals are its radii.
        rows, columns = np.nonzero(frame.mask == SPHERE)
        camera = frame.infos["depth"].K
        z = frame.depth[rows, columns]
        seen = np.column_stack([(columns - camera[2]) / camera[0] * z,
                                (rows - camera[5]) / camera[4] * z, z])
        radii = (seen - (SPHERE_CENTRE - EYE) @ axes(EYE, TARGET)) / SPHERE_RADIUS
        self.assertLess(np.abs(frame.normals[rows, columns] - radii).max(), 1e-3)
        self.assertTrue(np.array_equal(np.isnan(frame.normals[..., 0]), frame.mask == NOTHING))

    def test_visible_points(self):
        """Also without a subscriber to images. Depth shows the same points, except at edges of pixels."""
        recorder = Recorder("/clothsim/camera/visible_points", VisiblePoints)
        wait_for(recorder.connected, "the points that are seen")
        state = self.cloth.step(40)
        def has_its_stamp(message):
            return message.header.stamp == state.header.stamp
        message = recorder.wait("points at %s" % state.header.stamp, has_its_stamp)
        recorder.close()
        self.assertEqual((message.header.frame_id, message.topology_seq),
                         (OWN_FRAME, state.topology_seq))
        self.assertEqual(sorted(set(message.points)), list(message.points))

        self.subscribe()
        frame = self.camera.frame(state.header.stamp)
        by_depth = set(self.seen_points(state, frame)[0])
        self.assertLess(len(by_depth.symmetric_difference(message.points)), 0.05 * len(by_depth))

    # ---- Times of images ----

    def test_nothing_is_drawn_without_subscribers(self):
        self.cloth.pause(False)
        before = self.diagnostics.drawn()
        self.cloth.states.clear()
        wait_for(lambda: len(self.cloth.states.all()) > 90, "90 frames")
        self.assertEqual(self.diagnostics.drawn(), before)

        self.subscribe()
        more = self.diagnostics.drawn()
        self.assertGreater(more, before)

        self.camera.close()
        self.diagnostics.next(lambda s: s.values["images subscribed"] == "none")
        before = self.diagnostics.drawn()
        self.cloth.states.clear()
        wait_for(lambda: len(self.cloth.states.all()) > 90, "90 frames")
        self.assertEqual(self.diagnostics.drawn(), before)

    def test_diagnostics_name_the_device(self):
        self.subscribe()
        status = self.diagnostics.next(lambda s: int(s.values["pictures drawn"]) > 0)
        self.assertEqual(status.level, DiagnosticStatus.OK)
        self.assertIn("OpenGL", status.values["OpenGL"])
        self.assertGreaterEqual(int(status.values["pictures dropped"]), 0)

    def test_lockstep(self):
        """The pictures of a step's last frame are published when it returns, and so are those that are
        due in between: 20 a second, thus each fifth of 90 frames, or fourth where that is nearer."""
        self.subscribe()
        for frames in (1, 1, 2, 5):
            self.step(frames)
        self.cloth.reset()
        self.camera.clear()
        self.cloth.states.clear()
        state, _ = self.step(90)
        stamps = self.camera.stamps()
        self.assertEqual(stamps[-1], state.header.stamp)
        self.cloth.states.wait("the last state", lambda s: s.step == 90)
        number = {s.header.stamp: s.step for s in self.cloth.states.all()}
        steps = [number[stamp] for stamp in stamps if number.get(stamp, 0) > 0]
        self.assertEqual(steps[-1], 90)
        self.assertIn(len(steps), (20, 21))
        self.assertEqual({b - a for a, b in zip(steps[:-1], steps[1:-1])}, {4, 5})

    def test_fewer_pictures_than_steps(self):
        """The images that the rate asks for, none of them late: 30 Hz are each third of 90 frames."""
        self.viewpoint.update_configuration({"rate": 30.0, "each_step": False})
        self.subscribe()
        self.cloth.reset()
        stamps = [self.cloth.step(1).header.stamp for _ in range(30)]
        self.camera.frame(stamps[-1])
        self.diagnostics.next()  # images that are not wanted have had time to arrive
        self.assertEqual([s for s in self.camera.stamps() if s >= stamps[0]], stamps[2::3])
        # Now all of them.
        self.viewpoint.update_configuration({"each_step": True})
        stamps = [self.cloth.step(1).header.stamp for _ in range(4)]
        self.camera.frame(stamps[-1])
        self.assertEqual([s for s in self.camera.stamps() if s >= stamps[0]], stamps)

    def test_same_steps_same_pictures(self):
        self.subscribe()

        def pictures():
            self.cloth.reset()
            frames = [self.step(10)[1] for _ in range(3)]
            return [(f.color.tobytes(), f.depth.tobytes(), f.mask.tobytes()) for f in frames]
        self.assertEqual(pictures(), pictures())

    def test_a_paused_simulation_is_shown_to_a_new_subscriber(self):
        stamp = self.cloth.step(30).header.stamp
        self.subscribe()
        self.camera.frame(stamp)

    # ---- A camera on a tf frame ----

    def send_frame(self, broadcaster, eye, target, frame="hand_optical"):
        t = make_transform(frame, eye, stamp=rospy.Time.now())
        r = t.transform.rotation
        r.x, r.y, r.z, r.w = quaternion(axes(eye, target))
        broadcaster.sendTransform(t)

    def test_camera_on_a_frame(self):
        self.subscribe()
        broadcaster = tf2_ros.TransformBroadcaster()
        self.viewpoint.update_configuration({"frame": "hand_optical"})
        _, frame = self.step(1)
        self.assertEqual(frame.images["color"].header.frame_id, OWN_FRAME)  # not seen yet
        status = self.diagnostics.next(lambda s: "tf age of hand_optical [s]" in s.values)
        self.assertEqual(status.values["tf age of hand_optical [s]"], "not seen yet")

        # While the simulation is paused, the sphere's middle is where each pose puts it.
        for eye in (np.array([2.0, 0.5, 0.9]), np.array([0.5, 2.2, 0.4])):
            target = np.array([0.45, 0.55, 0.3])

            def sees_the_sphere(eye=eye, target=target):
                self.send_frame(broadcaster, eye, target)
                self.camera.clear()
                _, picture = self.step(1)
                self.assertIn(picture.images["mask"].header.frame_id, (OWN_FRAME, "hand_optical"))
                rows, columns = np.nonzero(picture.mask == SPHERE)
                if len(rows) == 0 or picture.images["mask"].header.frame_id == OWN_FRAME:
                    return False
                pixel, _ = project(model(picture.infos["mask"]), SPHERE_CENTRE[None], eye, target)
                return np.allclose([columns.mean(), rows.mean()], pixel[0], atol=1.5)
            wait_for(sees_the_sphere, "a picture from %s" % eye)

        # Nobody broadcasts the frame: the camera stays at its last pose, and the node warns.
        self.diagnostics.next(lambda s: s.level == DiagnosticStatus.WARN
                              and "lost tf frame hand_optical" in s.message, "of a lost frame")
        _, picture = self.step(1)
        self.assertEqual(picture.images["mask"].header.frame_id, "hand_optical")

        self.viewpoint.update_configuration({"frame": ""})
        self.assertEqual(self.step(1)[1].images["mask"].header.frame_id, OWN_FRAME)


if __name__ == "__main__":
    rospy.init_node("camera_test")
    rostest.rosrun("clothsim", "camera", CameraTest)
