#pragma once

#include <string>
#include <vector>

namespace clothsim {

/// The one of `words` that `word` was probably meant to be, by edit distance without regard to
/// case; empty: none is near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& words);

}  // namespace clothsim
