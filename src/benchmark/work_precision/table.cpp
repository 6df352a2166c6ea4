#include "table.h"

#include <cassert>
#include <cmath>

#include "clothsim/model/checks.h"
#include "clothsim/model/files.h"

namespace clothsim::work_precision {
namespace {

std::string join(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : ",") + cells[i];
  return line;
}

std::string text_of(const Table::Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* count = std::get_if<int>(&cell)) return std::to_string(*count);
  const double number = std::get<double>(cell);
  return std::isfinite(number) ? to_text(number) : "";
}

}  // namespace

void Table::add(const std::vector<Cell>& row) {
  assert(row.size() == columns_.size());
  std::vector<std::string> cells;
  for (const Cell& cell : row) cells.push_back(text_of(cell));
  rows_.push_back(join(cells));
}

void Table::write(const std::filesystem::path& file) const {
  std::string contents = join(columns_) + '\n';
  for (const std::string& row : rows_) contents += row + '\n';
  write_file(file, contents);
}

}  // namespace clothsim::work_precision
