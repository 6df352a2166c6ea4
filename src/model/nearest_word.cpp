#include "clothsim/model/nearest_word.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace clothsim {
namespace {

bool alike(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

/// Levenshtein distance: letters to insert, delete or replace.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (alike(letter, b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& words) {
  std::size_t limit = std::max<std::size_t>(1, word.size() / 3) + 1;  // farther: another word
  std::string found;
  for (const std::string& candidate : words) {
    const std::size_t away = distance(word, candidate);
    if (away >= limit) continue;
    limit = away;
    found = candidate;
  }
  return found;
}

}  // namespace clothsim
