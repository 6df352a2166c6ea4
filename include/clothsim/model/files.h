#pragma once

#include <filesystem>
#include <string>

namespace clothsim {

/// Writes the whole file or nothing: first as `path`.part, which then replaces `path`. Throws
/// std::runtime_error, also where the disk is full.
void write_file(const std::filesystem::path&, const std::string& contents);

}  // namespace clothsim
