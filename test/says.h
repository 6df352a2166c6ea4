#pragma once

#include <gtest/gtest.h>

#include <string>

namespace clothsim {

/// Whether a message has all parts of `pattern`, which " ... " separates, in their order; it must
/// begin with the first of them, unless the pattern begins with "... ". So a test asks for key,
/// value and reason, "cloth.ks: got -5 ... 0 [N/m]", and leaves the other words of a message open.
inline ::testing::AssertionResult says(const std::string& message, const std::string& pattern) {
  const std::string gap = " ... ";
  std::string rest = pattern.rfind("... ", 0) == 0 ? ' ' + pattern : gap + pattern;
  std::size_t from = 0;
  while (!rest.empty()) {
    const bool first = rest.size() == gap.size() + pattern.size();
    rest.erase(0, gap.size());
    const std::string part = rest.substr(0, rest.find(gap));
    rest.erase(0, part.size());
    const std::size_t at = message.find(part, from);
    if (at == std::string::npos || (first && at > 0)) {
      return ::testing::AssertionFailure()
             << '"' << message << "\" has no \"" << part << "\" of \"" << pattern << '"';
    }
    from = at + part.size();
  }
  return ::testing::AssertionSuccess();
}

}  // namespace clothsim
