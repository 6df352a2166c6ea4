#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace clothsim {

/// Threads that share loops over points or springs. The default, one, starts no thread and costs
/// nothing: the loop runs in the calling thread.
///
///   workers.parallel_for(n, [&](int begin, int end) { ... });
///
/// calls the body for bands that together are [0, n), each once, and returns when all are done. A
/// band must not depend on another one; then the result is the same to the last bit with any number
/// of threads.
///
/// Why not OpenMP: a substep has some hundred such loops of 10 to 200 us, so a thread spins for a
/// moment before it sleeps, and threads that are awake take the bands of those that are not. GCC's
/// OpenMP waits for all its threads, which is slow on a busy machine, and ThreadSanitizer does not
/// see its barriers. A thread takes the same bands of equal loops, as long as it is awake: it has
/// their data in its cache.
class Workers {
 public:
  /// `threads`: at least 1, including the calling thread. Throws std::system_error where a thread
  /// cannot be started.
  Workers();  // one
  explicit Workers(int threads);
  ~Workers();
  Workers(Workers&&) noexcept;
  Workers& operator=(Workers&&) noexcept;

  int threads() const;

  /// Bands per thread of a loop whose parts take unequal times: a thread that is done takes another
  /// band.
  static constexpr int uneven = 4;
  /// Least band of a loop whose parts cost more than a point or a spring.
  static constexpr int dear = 64;
  /// Least band of a loop whose parts cost much more.
  static constexpr int dearest = 8;

  /// To be called from one thread at a time, and not from within a body. With several threads a
  /// body that throws does not end the loop, which throws one of the exceptions at its end.
  /// Bands are at least `min_band` long, except in a loop shorter than two of them.
  template <typename Body>
  void parallel_for(int count, const Body& body, int min_band = 1024,
                    int bands_a_thread = 1) const {
    if (!pool_ || count < 2 * min_band) {
      body(0, count);
    } else {
      run({[](const void* b, int begin, int end) { (*static_cast<const Body*>(b))(begin, end); },
           &body, count, min_band, bands_a_thread, nullptr});
    }
  }

  /// Calls body(k) for parts in stages: those of a stage begin when all of earlier ones have ended.
  /// `ends`: one more than the last part of each stage; not empty. One loop costs less than one a
  /// stage.
  template <typename Body>
  void in_stages(const std::vector<int>& ends, const Body& body) const {
    const int count = ends.back();
    if (pool_) {
      run({[](const void* b, int k, int) { (*static_cast<const Body*>(b))(k); }, &body, count, 1,
           count, &ends});
    } else {
      for (int k = 0; k < count; ++k) body(k);
    }
  }

  /// Calls body(k) for each of `count` expensive parts.
  template <typename Body>
  void each(int count, const Body& body) const {
    parallel_for(
        count,
        [&](int begin, int end) {
          for (int k = begin; k < end; ++k) body(k);
        },
        dear, uneven);
  }

  /// Results of body(begin, end, result) for the bands of a loop over expensive parts, in order.
  template <typename Result, typename Body>
  std::vector<Result> gather(int count, const Body& body, int min_band = dear,
                             int bands_a_thread = uneven) const {
    std::mutex mutex;
    std::map<int, Result> found;  // by the first part
    parallel_for(
        count,
        [&](int begin, int end) {
          Result result;
          body(begin, end, result);
          const std::lock_guard<std::mutex> lock(mutex);
          found[begin] = std::move(result);
        },
        min_band, bands_a_thread);
    std::vector<Result> results;
    for (auto& [begin, result] : found) results.push_back(std::move(result));
    return results;
  }

 private:
  struct Loop {
    void (*call)(const void* body, int begin, int end);
    const void* body;
    int count;
    int min_band;
    int bands_a_thread;
    const std::vector<int>* stages;  // ends, in bands; null: a single one
  };
  struct Pool;

  void run(const Loop&) const;

  std::unique_ptr<Pool> pool_;  // none: one thread
};

}  // namespace clothsim
