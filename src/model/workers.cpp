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

/// How long a thread without work stays awake: longer than what lies between two loops of a
/// substep, shorter than what lies between two frames.
constexpr std::chrono::microseconds awake{600};

/// Looks at what others still do before the caller gives way to them.
constexpr int patience = 4000;

/// Bands begin at multiples of this, unless they may be shorter: a line of the caches, which two
/// threads should not both write.
constexpr int line = 8;

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

}  // namespace

struct Workers::Pool {
  explicit Pool(int helpers) {
    for (int i = 0; i < helpers; ++i) threads.emplace_back([this] { help(); });
  }

  ~Pool() {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      stopped = true;
      ++round;
    }
    wake.notify_all();
    for (std::thread& thread : threads) thread.join();
  }

  /// The caller's part.
  void run(const Loop& l) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      loop = l;
      const int most = l.bands_a_thread * (static_cast<int>(threads.size()) + 1);
      bands = std::min(most, l.count / l.least);
      next = 0;
      is_open = true;
      ++round;
    }
    if (sleepers > 0) wake.notify_all();
    take_bands();

    // Nobody comes in any more; those inside finish their bands.
    {
      const std::lock_guard<std::mutex> lock(mutex);
      is_open = false;
    }
    for (int i = 0; inside.load(std::memory_order_acquire) > 0; ++i) {
      i < patience ? relax() : std::this_thread::yield();
    }
  }

  /// What each other thread does.
  void help() {
    unsigned seen = 0;
    while (wait_for_round(seen)) {
      {
        const std::lock_guard<std::mutex> lock(mutex);
        if (stopped) return;  // the last round: to wait for another would be for ever
        seen = round;
        if (!is_open) continue;
        ++inside;
      }
      take_bands();
      inside.fetch_sub(1, std::memory_order_release);
    }
  }

  /// Until another round than `seen` has begun; false when the pool ends.
  bool wait_for_round(unsigned seen) {
    const auto deadline = std::chrono::steady_clock::now() + awake;
    while (round.load(std::memory_order_acquire) == seen) {
      if (std::chrono::steady_clock::now() < deadline) {
        relax();
        continue;
      }
      std::unique_lock<std::mutex> lock(mutex);
      ++sleepers;
      wake.wait(lock, [&] { return round != seen; });
      --sleepers;
    }
    return !stopped;
  }

  void take_bands() {
    const int multiple = loop.least < line ? 1 : line;
    const auto begin_of = [&](int band) {
      if (band == bands) return loop.count;
      const auto begin = static_cast<int>(static_cast<long long>(loop.count) * band / bands);
      return begin / multiple * multiple;
    };
    for (int band = next++; band < bands; band = next++) {
      loop.call(loop.body, begin_of(band), begin_of(band + 1));
    }
  }

  std::mutex mutex;
  std::condition_variable wake;
  std::atomic<unsigned> round{0};  // counts the loops; changed under the mutex
  std::atomic<int> sleepers{0};
  std::atomic<int> inside{0};  // threads that may take bands, but the caller
  std::atomic<int> next{0};    // band nobody has taken
  std::atomic<bool> stopped{false};
  bool is_open = false;  // under the mutex; the next two change while it is shut and nobody inside
  Loop loop{};
  int bands = 0;
  std::vector<std::thread> threads;
};

Workers::Workers() = default;
Workers::Workers(int threads) {
  assert(threads >= 1);
  if (threads > 1) pool_ = std::make_unique<Pool>(threads - 1);
}
Workers::~Workers() = default;
Workers::Workers(Workers&&) noexcept = default;
Workers& Workers::operator=(Workers&&) noexcept = default;

int Workers::threads() const { return pool_ ? static_cast<int>(pool_->threads.size()) + 1 : 1; }

void Workers::run(const Loop& loop) const { pool_->run(loop); }

}  // namespace clothsim
