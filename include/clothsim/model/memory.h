#pragma once

#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// The internal state of a simulation between steps, as a list of numbers: each part writes its own
/// and reads them in the same order, so that a run continues with the same bits.
class MemoryWriter {
 public:
  void add(double number) { numbers_.push_back(number); }
  void add(const Vector3&);
  void add(const Points&);  // without the number of points

  const std::vector<double>& numbers() const { return numbers_; }

 private:
  std::vector<double> numbers_;
};

/// Reads numbers from any source. All calls throw InvalidValue with the key {"memory"} for values
/// that no part can have written.
class MemoryReader {
 public:
  /// `numbers` must outlive this.
  explicit MemoryReader(const std::vector<double>& numbers) : numbers_(numbers) {}

  double number();              // magnitude up to 1e12
  double energy();              // finite [J]
  int index(std::size_t size);  // from 0 to size - 1
  std::size_t count();          // of the items that follow, each of at least one number
  Vector3 vector();
  Points points(Eigen::Index rows);

  /// Throws unless all numbers have been read.
  void finish() const;

 private:
  void need(std::size_t count) const;
  double number_up_to(double most);

  const std::vector<double>& numbers_;
  std::size_t next_ = 0;
};

}  // namespace clothsim
