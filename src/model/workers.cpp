#include "clothsim/model/workers.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace clothsim {
namespace {

/// How long an idle thread spins: longer than the time between two loops of a substep, shorter than
/// the time between two frames.
constexpr std::chrono::microseconds awake{600};

/// How often the calling thread polls the others before it yields to them.
constexpr int patience = 4000;

/// Bands begin at multiples of this, unless they may be shorter: a cache line, which two threads
/// should not both write.
constexpr int line = 8;

/// More than the number of threads.
constexpr int shut = 1 << 20;

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

}  // namespace

struct Workers::Pool {
  explicit Pool(int count) : helpers(static_cast<std::size_t>(count)) {
    for (int i = 0; i < count; ++i) {
      helpers[static_cast<std::size_t>(i)].thread = std::thread([this, i] { help(i); });
    }
  }

  ~Pool() {
    stopped = true;
    begin_round(static_cast<int>(helpers.size()));
    for (Helper& helper : helpers) helper.thread.join();
  }

  /// The part of the calling thread.
  void run(const Loop& l) {
    loop = l;
    const int count = static_cast<int>(helpers.size());
    bands = std::min(l.bands_a_thread * (count + 1), l.count / l.min_band);
    next.store(0, std::memory_order_relaxed);
    inside.fetch_add(shut, std::memory_order_release);
    begin_round(std::min(bands - 1, count));
    take_bands();

    // No thread enters any more; those inside finish their bands.
    inside.fetch_sub(shut, std::memory_order_relaxed);
    for (int i = 0; inside.load(std::memory_order_acquire) != -shut; ++i) {
      i < patience ? relax() : std::this_thread::yield();
    }
  }

  /// Signals the first `count` threads that there is work.
  void begin_round(int count) {
    wanted = count;
    ++round;
    for (int i = 0; i < count; ++i) {
      Helper& helper = helpers[static_cast<std::size_t>(i)];
      if (!helper.sleeps) continue;
      { const std::lock_guard<std::mutex> lock(helper.mutex); }  // it waits, or checks again
      helper.wake.notify_one();
    }
  }

  /// The loop of each other thread.
  void help(int number) {
    for (unsigned seen = 0; wait_for_round(number, seen);) {
      if (inside.fetch_add(1, std::memory_order_acquire) >= 0) take_bands();
      inside.fetch_sub(1, std::memory_order_release);
    }
  }

  /// Waits for a round other than `seen` that needs this thread; false when the pool ends.
  bool wait_for_round(int number, unsigned& seen) {
    Helper& self = helpers[static_cast<std::size_t>(number)];
    const auto is_wanted = [&] {
      const unsigned now = round;
      if (now == seen) return false;
      seen = now;
      return number < wanted;
    };
    const auto deadline = std::chrono::steady_clock::now() + awake;
    while (!is_wanted()) {
      if (std::chrono::steady_clock::now() < deadline) {
        relax();
        continue;
      }
      std::unique_lock<std::mutex> lock(self.mutex);
      self.sleeps = true;
      self.wake.wait(lock, is_wanted);
      self.sleeps = false;
      break;
    }
    return !stopped;
  }

  void take_bands() {
    const int multiple = loop.min_band < line ? 1 : line;
    const auto begin_of = [&](int band) {
      if (band == bands) return loop.count;
      const auto begin = static_cast<int>(static_cast<long long>(loop.count) * band / bands);
      return begin / multiple * multiple;
    };
    for (int band = next++; band < bands; band = next++) {
      loop.call(loop.body, begin_of(band), begin_of(band + 1));
    }
  }

  struct Helper {
    std::thread thread;
    std::mutex mutex;
    std::condition_variable wake;
    std::atomic<bool> sleeps{false};
  };

  // Each on its own cache line: all threads poll the first two while they wait.
  alignas(64) std::atomic<unsigned> round{0};  // counts the loops
  std::atomic<int> wanted{0};                  // threads that take part in the round
  std::atomic<bool> stopped{false};
  alignas(64) std::atomic<int> inside{-shut};  // threads that may take bands; below 0: closed
  alignas(64) std::atomic<int> next{0};        // first band that is not taken
  alignas(64) Loop loop{};                     // changes while closed and without threads inside
  int bands = 0;
  std::vector<Helper> helpers;
};

Workers::Workers() = default;
Workers::Workers(int threads) {
  assert(threads >= 1);
  if (threads > 1) pool_ = std::make_unique<Pool>(threads - 1);
}
Workers::~Workers() = default;
Workers::Workers(Workers&&) noexcept = default;
Workers& Workers::operator=(Workers&&) noexcept = default;

int Workers::threads() const { return pool_ ? static_cast<int>(pool_->helpers.size()) + 1 : 1; }

void Workers::run(const Loop& loop) const { pool_->run(loop); }

}  // namespace clothsim
