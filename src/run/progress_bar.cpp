#include "clothsim/run/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace clothsim {

ProgressBar::ProgressBar(long long total)
    : total_(total), on_terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (on_terminal_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::update(long long done) {
  const Clock::time_point now = Clock::now();
  if (!on_terminal_ || now < next_) return;
  next_ = now + std::chrono::milliseconds(100);

  std::string bar = "----------------------------------------";
  const double share = static_cast<double>(done) / static_cast<double>(total_);
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double left = done > 0 ? elapsed / share - elapsed : 0;
  std::fill_n(bar.begin(), static_cast<std::ptrdiff_t>(share * static_cast<double>(bar.size())),
              '#');
  std::fprintf(stderr, "\r[%s] %3.0f %%  %lld/%lld  %.0f s left\033[K", bar.c_str(), 100 * share,
               done, total_, left);
  std::fflush(stderr);
}

}  // namespace clothsim
