#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clothsim/model/errors.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Bounds of a value, and its unit as messages show it (empty: none). The upper bounds are far
/// beyond any cloth; they keep squares and quotients of accepted values finite.
struct Range {
  double min;
  double max;
  const char* unit;
};

/// Throws InvalidValue when `value` is outside `range` or not finite.
void check_range(const std::string& key, double value, const Range& range);

/// The same for an integer; the bounds of `range` must be integers, too.
void check_range(const std::string& key, int value, const Range& range);

/// The same for each component, with keys {key, "0"} to {key, "2"}.
void check_range(const std::string& key, const Vector3& value, const Range& range);

/// Throws InvalidValue unless `frame` is empty or a name that tf2 accepts.
void check_frame(const std::string& frame);

/// The shortest text that reads back as `value`.
std::string to_text(double value);

/// The words with commas between them, as in messages.
std::string join(const std::vector<std::string>& words);

/// The first `longest` bytes of a text and an ellipsis, for messages that repeat long texts.
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
