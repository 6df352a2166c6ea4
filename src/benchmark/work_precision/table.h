#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace clothsim::work_precision {

/// Rows under a header, written as CSV. NaN becomes an empty field.
class Table {
 public:
  using Cell = std::variant<std::string, double, int>;

  explicit Table(std::vector<std::string> columns) : columns_(std::move(columns)) {}

  void add(const std::vector<Cell>& row);
  void write(const std::filesystem::path& file) const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::string> rows_;
};

}  // namespace clothsim::work_precision
