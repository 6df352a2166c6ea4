#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clothsim/model/errors.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// The numbers a value may take, and its unit as messages show it (empty: none). The upper bounds
/// are far beyond any cloth; they keep squares and quotients of accepted values finite.
struct Range {
  double min;
  double max;
  const char* unit;
};

/// Throws InvalidValue when `value` is outside `range` or not finite.
void check_range(const std::string& key, double value, const Range& range);

/// The same for a whole number between bounds of `range`, which are whole too.
void check_range(const std::string& key, int value, const Range& range);

/// The same for each component, with keys {key, "0"} to {key, "2"}.
void check_range(const std::string& key, const Vector3& value, const Range& range);

/// Throws InvalidValue unless `frame` is empty or a name that tf2 accepts.
void check_frame(const std::string& frame);

/// The shortest text that reads back as `value`.
std::string to_text(double value);

/// The words one after the other, with commas, as messages list them.
std::string join(const std::vector<std::string>& words);

/// The first `longest` bytes of a text and an ellipsis, as messages repeat what may be long.
std::string shortened(const std::string& text, std::size_t longest);

/// Runs `action`; an InvalidValue it throws gets `parent` before its key.
template <class Action>
void inside(const std::string& parent, Action&& action) {
  try {
    action();
  } catch (const InvalidValue& error) {
    throw error.inside(parent);
  }
}

}  // namespace clothsim
