#include "clothsim/model/errors.h"

#include <utility>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Longest part of a message [characters]: the path of a file fits, and a name of megabytes does
/// not.
constexpr size_t longest_part = 1000;

/// The text without control characters, which a file may contain and a terminal would execute.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  }
  return text;
}

std::string format(const std::vector<std::string>& key, const std::string& prefix,
                   const std::string& separator, const std::string& got,
                   const std::string& expected) {
  std::string path = prefix;
  for (size_t i = 0; i < key.size(); ++i) {
    path += (i == 0 ? "" : separator) + shortened(key[i], longest_part);
  }
  return printable(path + ": got " + shortened(got, longest_part) + ", expected " +
                   shortened(expected, longest_part));
}

/// An error about the whole has no key.
std::vector<std::string> named(const std::vector<std::string>& key) {
  return key.empty() ? std::vector<std::string>{"scene"} : key;
}

}  // namespace

InvalidValue::InvalidValue(std::vector<std::string> key, std::string got, std::string expected)
    : std::runtime_error(format(named(key), "", ".", got, expected)),
      key_(std::move(key)),
      got_(std::move(got)),
      expected_(std::move(expected)) {}

std::string InvalidValue::message(const std::string& prefix, const std::string& separator) const {
  return format(key_, prefix, separator, got_, expected_);
}

InvalidValue InvalidValue::inside(const std::string& parent) const {
  std::vector<std::string> key{parent};
  key.insert(key.end(), key_.begin(), key_.end());
  return InvalidValue(std::move(key), got_, expected_);
}

}  // namespace clothsim
