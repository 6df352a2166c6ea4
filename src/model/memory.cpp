#include "clothsim/model/memory.h"

#include <cmath>
#include <limits>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Bound on a simulation's numbers other than energies.
constexpr double largest = 1e12;

[[noreturn]] void refuse(const std::string& got, const std::string& expected) {
  throw InvalidValue({"memory"}, got, expected);
}

}  // namespace

void MemoryWriter::add(const Vector3& vector) {
  numbers_.insert(numbers_.end(), vector.data(), vector.data() + 3);
}

void MemoryWriter::add(const Points& points) {
  numbers_.insert(numbers_.end(), points.data(), points.data() + points.size());
}

void MemoryReader::need(std::size_t count) const {
  if (count > numbers_.size() - next_) {
    refuse(std::to_string(numbers_.size()) + " numbers", "more");
  }
}

double MemoryReader::number() { return number_up_to(largest); }

double MemoryReader::energy() { return number_up_to(std::numeric_limits<double>::max()); }

double MemoryReader::number_up_to(double most) {
  need(1);
  const double value = numbers_[next_];
  if (!(std::abs(value) <= most)) {  // true for NaN
    refuse(to_text(value) + " at " + std::to_string(next_), "a number of at most " + to_text(most));
  }
  ++next_;
  return value;
}

int MemoryReader::index(std::size_t size) {
  const double value = number();
  if (!(value >= 0 && value < static_cast<double>(size) && value == std::floor(value))) {
    refuse(to_text(value) + " at " + std::to_string(next_ - 1),
           "a whole number from 0 to below " + std::to_string(size));
  }
  return static_cast<int>(value);
}

std::size_t MemoryReader::count() {
  return static_cast<std::size_t>(index(numbers_.size() - next_ + 1));
}

Vector3 MemoryReader::vector() {
  const double x = number();
  const double y = number();
  const double z = number();
  return {x, y, z};
}

Points MemoryReader::points(Eigen::Index rows) {
  need(static_cast<std::size_t>(3 * rows));
  Points all(rows, 3);
  for (Eigen::Index i = 0; i < all.size(); ++i) all.data()[i] = number();
  return all;
}

void MemoryReader::finish() const {
  if (next_ != numbers_.size()) {
    refuse(std::to_string(numbers_.size()) + " numbers", std::to_string(next_));
  }
}

}  // namespace clothsim
