#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "clothsim/model/types.h"

// NumPy's files: an NPY file holds an array; an NPZ file is a ZIP archive of NPY files, stored or
// deflated. https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html

namespace clothsim {

/// Numbers of an array, last index fastest.
struct NumberArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// The arrays of an NPZ file by name. Reads float64, float32, int64 and int32, little-endian.
/// Throws InvalidValue, with the name of the array as key if the error is in an array.
std::map<std::string, NumberArray> read_npz(const std::filesystem::path&);

/// N x 3 points, row by row.
NumberArray to_array(const Points&);

/// The whole of an NPY file, of float64 and of int32.
std::string to_npy(const NumberArray&);
std::string to_npy(const std::vector<std::size_t>& shape, const std::vector<std::int32_t>& values);

/// A temporary NPY file of float64 that grows along its first index, for write_npz(); the
/// destructor deletes it. Throws std::runtime_error where it cannot be written.
class GrowingNpy {
 public:
  /// `item`: the shape of each item appended.
  GrowingNpy(std::filesystem::path path, std::vector<std::size_t> item);
  ~GrowingNpy();
  GrowingNpy(const GrowingNpy&) = delete;
  GrowingNpy& operator=(const GrowingNpy&) = delete;

  void append(const std::vector<double>& item);

  /// Completes the file, until more is appended.
  void flush();

  const std::filesystem::path& path() const { return path_; }

 private:
  void write(const std::string& bytes);

  std::filesystem::path path_;
  std::vector<std::size_t> item_;
  std::size_t count_ = 0;
  std::fstream file_;
};

/// Writes an NPZ file: arrays, by name, as the bytes of NPY files or as NPY files. Stored, as
/// numpy.savez does. The whole file or nothing: throws std::runtime_error.
void write_npz(const std::filesystem::path&, const std::map<std::string, std::string>& arrays,
               const std::map<std::string, std::filesystem::path>& files = {});

}  // namespace clothsim
