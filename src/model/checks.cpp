#include "clothsim/model/checks.h"

#include <array>
#include <charconv>
#include <cmath>

namespace clothsim {

std::string to_text(double value) {
  if (std::isnan(value)) return "nan";  // without the sign bit, which to_chars would show
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), result.ptr);
}

void check_range(const std::string& key, double value, const Range& range) {
  const std::string unit = *range.unit == '\0' ? "" : std::string(" [") + range.unit + "]";
  if (!std::isfinite(value)) {
    throw InvalidValue({key}, to_text(value), "a finite number" + unit);
  }
  if (value < range.min) {
    throw InvalidValue({key}, to_text(value), "a number of at least " + to_text(range.min) + unit);
  }
  if (value > range.max) {
    throw InvalidValue({key}, to_text(value), "a number of at most " + to_text(range.max) + unit);
  }
}

void check_range(const std::string& key, int value, const Range& range) {
  if (value < range.min || value > range.max) {
    throw InvalidValue({key}, std::to_string(value),
                       "a whole number from " + std::to_string(std::llround(range.min)) + " to " +
                           std::to_string(std::llround(range.max)));
  }
}

void check_range(const std::string& key, const Vector3& value, const Range& range) {
  for (int axis = 0; axis < 3; ++axis) {
    inside(key, [&] { check_range(std::to_string(axis), value[axis], range); });
  }
}

void check_frame(const std::string& frame) {
  if (!frame.empty() && frame.front() == '/') {
    throw InvalidValue({"frame"}, '"' + frame + '"', "a tf frame without a leading slash");
  }
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string shortened(const std::string& text, std::size_t longest) {
  if (text.size() <= longest) return text;
  // Do not cut a UTF-8 character, whose later bytes are 10xxxxxx.
  while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0) == 0x80) --longest;
  return text.substr(0, longest) + "...";
}

}  // namespace clothsim
