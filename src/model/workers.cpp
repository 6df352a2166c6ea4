#include "clothsim/model/workers.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace clothsim {
namespace {

/// How long an idle thread spins: longer than the time between most loops of a substep.
constexpr std::chrono::microseconds awake{60};

/// How often a thread that waits for others polls them before it yields to them.
constexpr int patience = 4000;

/// Bands begin at multiples of this, unless they may be shorter: a cache line, which two threads
/// should not both write.
constexpr int line = 8;

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Waits for others, which have work.
template <typename Condition>
void wait_until(const Condition& holds) {
  for (int i = 0; !holds(); ++i) i < patience ? relax() : std::this_thread::yield();
}

}  // namespace

struct Workers::Pool {
  explicit Pool(int count) : helpers(static_cast<std::size_t>(count)) {
    try {
      for (int i = 0; i < count; ++i) helper(i).thread = std::thread([this, i] { help(i); });
    } catch (...) {
      end();
      throw;
    }
  }

  ~Pool() { end(); }

  /// Ends the threads that have started.
  void end() {
    stopped = true;
    const int count = static_cast<int>(helpers.size());
    open(count);
    for (int i = 0; i < count; ++i) wake(i);  // one that ended in the last round wakes no others
    for (Helper& each : helpers) {
      if (each.thread.joinable()) each.thread.join();
    }
  }

  /// The part of the calling thread.
  void run(const Loop& l) {
    loop = l;
    const int count = static_cast<int>(helpers.size());
    bands = std::min(l.bands_a_thread * (count + 1), l.count / l.min_band);
    one_stage = {bands};
    threads = std::clamp(widest_stage(), 1, count + 1);
    if (taken.size() < static_cast<std::size_t>(bands)) {
      taken = std::vector<std::atomic<std::uint64_t>>(static_cast<std::size_t>(bands));
    }
    done.store(0, std::memory_order_relaxed);
    ++loops;
    if (threads > 1) open(threads - 1);
    take_bands(0);
    if (threads > 1) close();
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
  }

  /// Ends the round: no thread enters any more; those inside finish their bands.
  void close() {
    ++round;
    for (int i = 0; i < threads - 1; ++i) {
      wait_until([&] { return !helper(i).is_inside; });
    }
  }

  const std::vector<int>& stages() const { return loop.stages ? *loop.stages : one_stage; }

  int widest_stage() const {
    int widest = 0, first = 0;
    for (const int end : stages()) {
      widest = std::max(widest, end - first);
      first = end;
    }
    return widest;
  }

  /// Begins a round for the first `count` threads.
  void open(int count) {
    wanted = count;
    ++round;
    wake(0);
  }

  /// Wakes a thread that is wanted. It wakes further ones, so this takes the caller little time.
  void wake(int number) {
    if (number >= wanted || !helper(number).sleeps) return;
    { const std::lock_guard<std::mutex> lock(helper(number).mutex); }  // it waits, or checks again
    helper(number).wake.notify_one();
  }

  /// The loop of each other thread.
  void help(int number) {
    std::atomic<bool>& is_inside = helper(number).is_inside;
    for (std::uint64_t seen = 0; wait_for_round(number, seen);) {
      is_inside = true;
      if (round == seen) take_bands(number + 1);
      is_inside.store(false, std::memory_order_release);
    }
  }

  /// Waits for a round other than `seen` that needs this thread; false when the pool ends.
  bool wait_for_round(int number, std::uint64_t& seen) {
    Helper& self = helper(number);
    const auto is_wanted = [&] {
      const std::uint64_t now = round;
      if (now == seen || now % 2 == 0) return false;
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
    for (const int other : {2 * number + 1, 2 * number + 2}) wake(other);
    return !stopped;
  }

  /// Takes the bands of a thread in each stage, then those that others have not begun.
  void take_bands(int thread) {
    int first = 0;
    for (const int end : stages()) {
      wait_until([&] { return done.load(std::memory_order_acquire) >= first; });
      const int count = end - first, own = count * thread / threads;
      for (int k = own; k < count; ++k) take(first + k);
      for (int k = 0; k < own; ++k) take(first + k);
      first = end;
    }
  }

  /// Does a band unless another thread has begun it.
  void take(int band) {
    std::atomic<std::uint64_t>& last = taken[static_cast<std::size_t>(band)];
    std::uint64_t before = last.load(std::memory_order_relaxed);
    if (before == loops || !last.compare_exchange_strong(before, loops)) return;
    try {
      loop.call(loop.body, begin_of(band), begin_of(band + 1));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex);
      failure = std::current_exception();
    }
    done.fetch_add(1, std::memory_order_release);
  }

  int begin_of(int band) const {
    if (band == bands) return loop.count;
    const int multiple = loop.min_band < line ? 1 : line;
    const auto begin = static_cast<int>(static_cast<long long>(loop.count) * band / bands);
    return begin / multiple * multiple;
  }

  struct alignas(64) Helper {
    std::atomic<bool> is_inside{false};  // may take bands
    std::atomic<bool> sleeps{false};
    std::thread thread;
    std::mutex mutex;
    std::condition_variable wake;
  };
  Helper& helper(int number) { return helpers[static_cast<std::size_t>(number)]; }

  // Each on its own cache line: all threads poll the first two while they wait.
  alignas(64) std::atomic<std::uint64_t> round{0};  // counts loops twice; odd while one is open
  std::atomic<int> wanted{0};                       // threads that take part in the round
  std::atomic<bool> stopped{false};
  alignas(64) std::atomic<int> done{0};  // bands of the loop
  // These change while closed and without threads inside.
  alignas(64) Loop loop{};
  std::uint64_t loops = 0;  // so far
  int bands = 0;
  int threads = 0;                                // that take part
  std::vector<int> one_stage;                     // for loops without stages
  std::vector<std::atomic<std::uint64_t>> taken;  // by band, the last loop in which it was begun
  std::mutex failure_mutex;
  std::exception_ptr failure;  // one that a body has thrown in this loop
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
