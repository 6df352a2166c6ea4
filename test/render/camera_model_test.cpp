#include <gtest/gtest.h>
#include <image_geometry/pinhole_camera_model.h>
#include <sensor_msgs/CameraInfo.h>

#include "render_fixture.h"

namespace clothsim::camera_model_test {
namespace {

// An off-centre principal point and pixels that are not square.
Camera odd_camera() {
  Camera camera;
  camera.width = 200;
  camera.height = 140;
  camera.fx = 180;
  camera.fy = 150;
  camera.cx = 71.25;
  camera.cy = 90.5;
  camera.pose = look_at({1.1, -2.3, 0.7}, {0.2, 0.4, 0.3});
  return camera;
}

image_geometry::PinholeCameraModel ros_model(const Camera& camera) {
  sensor_msgs::CameraInfo info;
  info.width = static_cast<unsigned>(camera.width);
  info.height = static_cast<unsigned>(camera.height);
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0);
  info.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  image_geometry::PinholeCameraModel model;
  model.fromCameraInfo(info);
  return model;
}

TEST(Camera, EveryPointLandsOnThePixelThatImageGeometrySays) {
  const Camera camera = odd_camera();
  const image_geometry::PinholeCameraModel model = ros_model(camera);

  // Random points in front of the camera, each a triangle a third of a pixel wide around the
  // centre of the pixel to which image_geometry projects it.
  constexpr int count = 264;
  Points positions(3 * count, 3);
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> expected_pixels;
  std::srand(7);
  for (int i = 0; i < count; ++i) {
    const int column = i % 22, row = i / 22;
    const cv::Point2d pixel(4 + 9 * column, 5 + 11 * row);
    const double depth = 0.5 + 0.01 * (std::rand() % 300);
    const cv::Point3d ray = model.projectPixelTo3dRay(pixel);
    const Vector3 center = depth / ray.z * Vector3(ray.x, ray.y, ray.z);
    const cv::Point2d back = model.project3dToPixel({center.x(), center.y(), center.z()});
    expected_pixels.push_back(static_cast<int>(std::lround(back.y)) * camera.width +
                              static_cast<int>(std::lround(back.x)));
    const double reach = depth / 6 / camera.fx;
    const Vector3 corners[] = {{-reach, -reach, 0}, {reach, -reach, 0}, {0, reach, 0}};
    for (int k = 0; k < 3; ++k)
      positions.row(3 * i + k) =
          camera.pose.position + camera.pose.orientation * (center + corners[k]);
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }

  Images images;
  shared_renderer().render(triangle_cloth(positions, triangles), camera, {false, false, true},
                           images);
  std::vector<int> hit;
  for (int pixel = 0; pixel < camera.width * camera.height; ++pixel)
    if (images.mask[static_cast<std::size_t>(pixel)] == 1) hit.push_back(pixel);
  std::sort(expected_pixels.begin(), expected_pixels.end());
  EXPECT_EQ(hit, expected_pixels);
  EXPECT_EQ(hit.size(), static_cast<std::size_t>(count));
}

}  // namespace
}  // namespace clothsim::camera_model_test
