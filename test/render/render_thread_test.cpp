#include "clothsim/render/render_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "render_fixture.h"

namespace clothsim::render_thread_test {
namespace {

RenderJob job(const Snapshot& snapshot, std::function<void(const Images&)> done) {
  RenderJob result;
  result.snapshot = snapshot;
  result.camera = camera_with_fov(32, 24, 1);
  result.camera.pose = look_at({0.5, -1, 1}, {0.5, 0.5, 0});
  result.done = std::move(done);
  return result;
}

TEST(RenderThread, DrawsWhatARendererDraws) {
  const Snapshot snapshot = flat_cloth(8, 8);
  RenderThread thread({CLOTHSIM_SHADERS_DIR});
  Images drawn;
  std::thread::id drawn_by;
  const RenderJob one = job(snapshot, [&](const Images& images) {
    drawn = images;
    drawn_by = std::this_thread::get_id();
  });
  thread.submit(one);
  thread.wait();
  const Images expected = draw(snapshot, one.camera);
  EXPECT_EQ(drawn.color, expected.color);
  EXPECT_EQ(drawn.depth, expected.depth);
  EXPECT_EQ(drawn.mask, expected.mask);
  EXPECT_NE(drawn_by, std::this_thread::get_id());
  EXPECT_EQ(thread.status().drawn, 1);
  EXPECT_EQ(thread.status().dropped, 0);
  EXPECT_EQ(thread.status().failure, "");
  EXPECT_NE(thread.status().device, "");
}

TEST(RenderThread, TheNewestWaits) {
  RenderThread thread({CLOTHSIM_SHADERS_DIR});
  const Snapshot snapshot = flat_cloth(8, 8);
  std::promise<void> begun, go_on;
  thread.submit(job(snapshot, [&](const Images&) {
    begun.set_value();
    go_on.get_future().wait();
  }));
  begun.get_future().wait();

  // Busy with the first: of the others only the last is drawn.
  std::atomic<int> sum{0};
  for (const int number : {1, 10, 100})
    thread.submit(job(snapshot, [&sum, number](const Images&) { sum += number; }));
  go_on.set_value();
  thread.wait();
  EXPECT_EQ(sum, 100);
  EXPECT_EQ(thread.status().drawn, 2);
  EXPECT_EQ(thread.status().dropped, 2);
}

TEST(RenderThread, WithoutOpenGlNothingHappens) {
  RenderThread thread({CLOTHSIM_SHADERS_DIR, 99});
  bool drawn = false;
  thread.submit(job(flat_cloth(2, 2), [&](const Images&) { drawn = true; }));
  thread.wait();
  EXPECT_FALSE(drawn);
  EXPECT_NE(thread.status().failure.find("egl_device: got 99"), std::string::npos)
      << thread.status().failure;
  EXPECT_EQ(thread.status().drawn, 0);
}

TEST(RenderThread, AFailureIsToldUntilAPictureSucceeds) {
  RenderThread thread({CLOTHSIM_SHADERS_DIR});
  const Snapshot snapshot = flat_cloth(2, 2);
  thread.submit(job(snapshot, [](const Images&) { throw std::runtime_error("no room"); }));
  thread.wait();
  EXPECT_EQ(thread.status().failure, "no room");
  EXPECT_EQ(thread.status().drawn, 0);
  thread.submit(job(snapshot, [](const Images&) {}));
  thread.wait();
  EXPECT_EQ(thread.status().failure, "");
  EXPECT_EQ(thread.status().drawn, 1);
}

TEST(RenderThread, EndsWithAPictureOnItsWay) {
  for (int i = 0; i < 3; ++i) {
    RenderThread thread({CLOTHSIM_SHADERS_DIR});
    if (i > 0) thread.submit(job(flat_cloth(8, 8), [](const Images&) {}));
    if (i > 1) thread.wait();
  }
}

}  // namespace
}  // namespace clothsim::render_thread_test
