#pragma once

#include <string>
#include <vector>

namespace clothsim {

/// The one of `words` that may have been meant by `word`, by letters to insert, delete or replace,
/// of which capitals are none; empty: none is near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& words);

}  // namespace clothsim
