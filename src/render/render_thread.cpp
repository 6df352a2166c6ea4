#include "clothsim/render/render_thread.h"

#include <sys/resource.h>

#include <utility>

namespace clothsim {
namespace {

/// Niceness of the thread and of those that a software driver starts from it: the simulation has
/// priority over pictures.
constexpr int niceness = 5;

}  // namespace

RenderThread::RenderThread(const RendererOptions& options)
    : options_(options), thread_([this] { run(); }) {}

RenderThread::~RenderThread() {
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
    waiting_.reset();
  }
  changed_.notify_all();
  thread_.join();
}

void RenderThread::submit(RenderJob job) {
  {
    const std::lock_guard lock(mutex_);
    if (!alive_) return;
    if (waiting_) ++status_.dropped;
    waiting_ = std::move(job);
  }
  changed_.notify_all();
}

void RenderThread::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !alive_ || (!busy_ && !waiting_); });
}

RenderStatus RenderThread::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void RenderThread::run() {
  setpriority(PRIO_PROCESS, 0, niceness);  // on Linux this affects the calling thread only
  std::optional<Renderer> renderer;
  try {
    renderer.emplace(options_);
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    status_.failure = error.what();
    alive_ = false;
    waiting_.reset();
    changed_.notify_all();
    return;
  }

  Images images;
  std::unique_lock lock(mutex_);
  status_.device = renderer->device();
  while (true) {
    busy_ = false;
    changed_.notify_all();
    changed_.wait(lock, [this] { return end_ || waiting_; });
    if (end_) return;
    const RenderJob job = *std::exchange(waiting_, std::nullopt);
    busy_ = true;
    lock.unlock();
    draw(*renderer, job, images);
    lock.lock();
  }
}

void RenderThread::draw(Renderer& renderer, const RenderJob& job, Images& images) {
  std::string failure;
  try {
    renderer.render(job.snapshot, job.camera, job.wanted, images);
    job.done(images);
  } catch (const std::exception& error) {
    failure = error.what();
  }
  const std::lock_guard lock(mutex_);
  status_.failure = failure;
  if (!failure.empty()) return;
  ++status_.drawn;
  status_.times = renderer.times();
}

}  // namespace clothsim
