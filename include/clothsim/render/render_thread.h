#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clothsim/render/renderer.h"

namespace clothsim {

/// A picture to take.
struct RenderJob {
  Snapshot snapshot;
  Camera camera;
  WantedImages wanted;
  std::function<void(const Images&)> done;  // called in the render thread
};

/// Statistics of a render thread.
struct RenderStatus {
  std::string device;   // device of the OpenGL context; empty: none yet
  std::string failure;  // why the last picture failed, or the lack of OpenGL
  int drawn = 0;        // pictures
  int dropped = 0;      // pictures that a newer one replaced before they were drawn
  RenderTimes times;    // of the last picture
};

/// Draws in a thread of its own, which owns the OpenGL context throughout.
class RenderThread {
 public:
  /// The context is made in the background; status() has the error, if any.
  explicit RenderThread(const RendererOptions&);

  /// Finishes the picture that is being drawn.
  ~RenderThread();

  /// Replaces a waiting job, so that the newest is drawn next. Without OpenGL nothing happens.
  void submit(RenderJob);

  /// Waits until all submitted jobs are drawn, or have failed.
  void wait();

  RenderStatus status() const;

 private:
  void run();
  void draw(Renderer&, const RenderJob&, Images&);

  RendererOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<RenderJob> waiting_;
  bool busy_ = true;   // with a job, or making the context
  bool alive_ = true;  // false: no context
  bool end_ = false;
  RenderStatus status_;
  std::thread thread_;  // last, as it uses the others
};

}  // namespace clothsim
