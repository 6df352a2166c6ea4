#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include "clothsim/model/errors.h"
#include "clothsim/render/egl_context.h"
#include "render_fixture.h"

namespace clothsim::context_test {
namespace {

// A sanitizer keeps freed memory; there its leak check at exit decides.
#ifdef __SANITIZE_ADDRESS__
constexpr bool memory_tells = false;
#else
constexpr bool memory_tells = true;
#endif

/// Pages of this process in main memory.
long resident_pages() {
  long total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident;
}

/// Pages by which `cycle` makes this process grow each time: the minimum of three runs, as the
/// driver's and allocator's caches grow in some of them, and a leak in each.
template <typename Cycle>
long growth(const Cycle& cycle) {
  long least = std::numeric_limits<long>::max();
  for (int i = 0; i < 3; ++i) {
    const long before = resident_pages();
    cycle();
    least = std::min(least, resident_pages() - before);
  }
  return least;
}

TEST(Context, SaysWhereItCameFrom) {
  EXPECT_NE(shared_renderer().device().find("OpenGL"), std::string::npos)
      << shared_renderer().device();
}

TEST(Context, ADeviceCanBeChosenByIndex) {
  const std::vector<std::string> devices = egl_devices();
  ASSERT_FALSE(devices.empty());
  const int last = static_cast<int>(devices.size()) - 1;
  std::thread([&] {
    const EglContext context(last);
    EXPECT_EQ(context.description().find(devices.back()), 0u) << context.description();
  }).join();
}

TEST(Context, ADeviceThatDoesNotExistIsRefused) {
  try {
    const EglContext context(99);
    FAIL() << "made a context on device 99";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), std::vector<std::string>{"egl_device"});
    EXPECT_NE(std::string(error.what()).find("got 99"), std::string::npos) << error.what();
  }
}

TEST(Context, RenderersOfSeveralThreadsDrawTheSame) {
  const Snapshot snapshot = flat_cloth(8, 8);
  Camera camera = camera_with_fov(32, 24, 1);
  camera.pose = look_at({0.5, -1, 1}, {0.5, 0.5, 0});
  const Images expected = draw(snapshot, camera);

  std::array<Images, 2> images;
  std::array<std::thread, 2> threads;
  for (std::size_t i = 0; i < 2; ++i)
    threads[i] = std::thread([&, i] {
      Renderer renderer({CLOTHSIM_SHADERS_DIR});
      for (int frame = 0; frame < 20; ++frame) renderer.render(snapshot, camera, {}, images[i]);
    });
  for (std::thread& thread : threads) thread.join();
  for (const Images& image : images) {
    EXPECT_EQ(image.color, expected.color);
    EXPECT_EQ(image.depth, expected.depth);
    EXPECT_EQ(image.mask, expected.mask);
  }
}

TEST(Context, MakingAndDroppingRenderersKeepsMemoryFlat) {
  const Snapshot snapshot = flat_cloth(8, 8);
  const Camera camera = camera_with_fov(32, 24, 1);
  const auto cycle = [&](int count) {
    std::thread([&] {
      for (int i = 0; i < count; ++i) {
        Renderer renderer({CLOTHSIM_SHADERS_DIR});
        Images images;
        renderer.render(snapshot, camera, {}, images);
      }
    }).join();
  };
  cycle(5);
  const long grown = growth([&] { cycle(15); });
  // One leaked colour target of this size and its program are some 20 pages each.
  if (memory_tells) {
    EXPECT_LT(grown, 15 * 20 / 2);
  }
}

TEST(Context, ManyFramesAndSizesKeepMemoryFlat) {
  Snapshot snapshot = flat_cloth(20, 20);
  snapshot.colliders.resize(2);
  Images images;
  const auto cycle = [&](int count) {
    for (int i = 0; i < count; ++i) {
      move_cloth(snapshot, snapshot.cloth->rest_positions);
      snapshot.colliders[0].segments = 8 + i % 3;
      const Camera camera = camera_with_fov(32 + i % 5, 24, 1);
      shared_renderer().render(snapshot, camera, {}, images);
    }
  };
  cycle(50);
  const long grown = growth([&] { cycle(100); });
  // A leak of one vertex buffer a frame would be 100 times 4 pages.
  if (memory_tells) {
    EXPECT_LT(grown, 100 * 4 / 2);
  }
}

TEST(Context, OnlyWhatIsAskedForIsMade) {
  const Camera camera = camera_with_fov(8, 6, 1);
  Images images;
  shared_renderer().render({}, camera, {false, true, false}, images);
  EXPECT_TRUE(images.color.empty());
  EXPECT_EQ(images.depth.size(), 48u);
  EXPECT_TRUE(images.mask.empty());
}

}  // namespace
}  // namespace clothsim::context_test
