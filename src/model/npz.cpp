#include "clothsim/model/npz.h"

#include <zip.h>

#include <array>
#include <cstring>
#include <memory>
#include <regex>
#include <stdexcept>
#include <utility>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "NPY files are written as memory has them");

/// Larger arrays are not the state of a cloth [bytes].
constexpr std::uint64_t largest_array = 4'000'000'000;

/// Size of a header, a multiple of 64 as the format demands: room for every shape [bytes].
constexpr std::size_t header_size = 128;
constexpr std::size_t prefix_size = 10;  // magic, version, length
constexpr const char* magic = "\x93NUMPY";
constexpr std::size_t magic_size = 6;

std::string npy_header(const char* type, const std::vector<std::size_t>& shape) {
  std::string text = std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t size : shape) text += std::to_string(size) + ", ";
  text += "), }";
  text.resize(header_size - prefix_size - 1, ' ');
  text += '\n';
  std::string header(magic, magic_size);
  header += {1, 0, static_cast<char>(text.size() % 256), static_cast<char>(text.size() / 256)};
  return header + text;
}

template <class Number>
std::string as_bytes(const std::vector<Number>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)};
}

template <class Number>
std::vector<double> numbers(const char* bytes, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    Number value;
    std::memcpy(&value, bytes + i * sizeof(Number), sizeof(Number));
    values[i] = static_cast<double>(value);
  }
  return values;
}

/// A number type by its NPY name, and a function that reads it.
struct NumberType {
  const char* name;
  std::size_t size;
  std::vector<double> (*read)(const char*, std::size_t);
};

constexpr std::array<NumberType, 4> number_types = {{{"<f8", 8, numbers<double>},
                                                     {"<f4", 4, numbers<float>},
                                                     {"<i8", 8, numbers<std::int64_t>},
                                                     {"<i4", 4, numbers<std::int32_t>}}};

/// Throws InvalidValue without a key.
NumberArray parse_npy(const std::string& bytes) {
  const InvalidValue no_npy({}, "no NPY file of version 1 or 2", "one as numpy.savez writes it");
  const bool is_npy = bytes.size() > 12 && bytes.compare(0, magic_size, magic) == 0;
  const int version = is_npy ? bytes[magic_size] : 0;
  if (version != 1 && version != 2) throw no_npy;
  const std::size_t begin = version == 1 ? 10 : 12;
  std::size_t length = 0;
  for (std::size_t i = begin; i-- > 8;)
    length = length * 256 + static_cast<unsigned char>(bytes[i]);
  if (length > bytes.size() - begin) throw no_npy;
  const std::string header = bytes.substr(begin, length);

  std::smatch type, shape;
  static const std::regex type_text("'descr': *'([^']*)'"),
      shape_text("'shape': *\\(([0-9, ]*)\\)");
  if (!std::regex_search(header, type, type_text) ||
      !std::regex_search(header, shape, shape_text) ||
      header.find("'fortran_order': False") == std::string::npos) {
    throw InvalidValue({}, "no simple array in C order", "numbers");
  }
  NumberArray array;
  const std::string sizes = shape[1];
  for (std::size_t at = 0; at < sizes.size(); ++at) {
    if (sizes[at] < '0' || sizes[at] > '9') continue;
    std::size_t end = 0;
    array.shape.push_back(std::stoull(sizes.substr(at, 19), &end));
    at += end;
  }
  for (const NumberType& known : number_types) {
    if (type[1] != known.name) continue;
    std::size_t count = (bytes.size() - begin - length) / known.size;
    std::size_t needed = 1;
    for (const std::size_t size : array.shape) {
      if (size > 0 && needed > count / size)
        needed = count + 1;  // more than there are: fails below
      else
        needed *= size;
    }
    if (needed != count) throw InvalidValue({}, "numbers that do not fill its shape", "as many");
    array.values = known.read(bytes.data() + begin + length, count);
    return array;
  }
  throw InvalidValue({}, "numbers of type " + type[1].str(), "one of <f8, <f4, <i8, <i4");
}

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

std::string zip_message(int code) {
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

std::string read_entry(zip_t* archive, zip_uint64_t index, std::string& name) {
  zip_stat_t entry;
  zip_stat_init(&entry);
  if (zip_stat_index(archive, index, 0, &entry) != 0 || !(entry.valid & ZIP_STAT_SIZE)) {
    throw InvalidValue({}, "an archive that cannot be read", "a ZIP archive of NPY files");
  }
  name = entry.name;
  if (name.size() > 4 && name.compare(name.size() - 4, 4, ".npy") == 0)
    name.resize(name.size() - 4);
  if (entry.size > largest_array) {
    throw InvalidValue({name}, std::to_string(entry.size) + " bytes",
                       "at most " + std::to_string(largest_array));
  }
  const std::unique_ptr<zip_file_t, Discard> file(zip_fopen_index(archive, index, 0));
  std::string bytes(entry.size, '\0');
  if (!file ||
      zip_fread(file.get(), bytes.data(), bytes.size()) != static_cast<zip_int64_t>(bytes.size())) {
    throw InvalidValue({name}, zip_strerror(archive), "an NPY file that can be read");
  }
  return bytes;
}

}  // namespace

std::map<std::string, NumberArray> read_npz(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) {
    throw InvalidValue({}, "no regular file", "an NPZ file");
  }
  int code = 0;
  const std::unique_ptr<zip_t, Discard> archive(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (!archive) throw InvalidValue({}, zip_message(code), "an NPZ file, as numpy.savez writes it");
  std::map<std::string, NumberArray> arrays;
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    std::string name;
    const std::string bytes = read_entry(archive.get(), static_cast<zip_uint64_t>(i), name);
    inside(name, [&] { arrays[name] = parse_npy(bytes); });
  }
  return arrays;
}

NumberArray to_array(const Points& points) {
  const auto count = static_cast<std::size_t>(points.rows());
  NumberArray array{{count, 3}, std::vector<double>(3 * count)};
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  Eigen::Map<Rows>(array.values.data(), points.rows(), 3) = points;
  return array;
}

std::string to_npy(const NumberArray& array) {
  return npy_header("<f8", array.shape) + as_bytes(array.values);
}

std::string to_npy(const std::vector<std::size_t>& shape, const std::vector<std::int32_t>& values) {
  return npy_header("<i4", shape) + as_bytes(values);
}

GrowingNpy::GrowingNpy(std::filesystem::path path, std::vector<std::size_t> item)
    : path_(std::move(path)),
      item_(std::move(item)),
      file_(path_, std::ios::in | std::ios::out | std::ios::binary | std::ios::trunc) {
  flush();
}

GrowingNpy::~GrowingNpy() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void GrowingNpy::append(const std::vector<double>& item) {
  write(as_bytes(item));
  ++count_;
}

void GrowingNpy::flush() {
  std::vector<std::size_t> shape = item_;
  shape.insert(shape.begin(), count_);
  file_.seekp(0);
  write(npy_header("<f8", shape));
  file_.seekp(0, std::ios::end);
  file_.flush();
}

void GrowingNpy::write(const std::string& bytes) {
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file_) throw std::runtime_error("cannot write " + path_.string());
}

void write_npz(const std::filesystem::path& path, const std::map<std::string, std::string>& arrays,
               const std::map<std::string, std::filesystem::path>& files) {
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error("cannot write " + path.string() + ": " + why);
  };
  int code = 0;
  std::unique_ptr<zip_t, Discard> archive(zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code));
  if (!archive) fail(zip_message(code));
  const auto add = [&](const std::string& name, zip_source_t* source) {
    const zip_int64_t index =
        source ? zip_file_add(archive.get(), (name + ".npy").c_str(), source, 0) : -1;
    if (index < 0) {
      if (source) zip_source_free(source);
      fail(zip_strerror(archive.get()));
    }
    const auto entry = static_cast<zip_uint64_t>(index);
    zip_set_file_compression(archive.get(), entry, ZIP_CM_STORE, 0);
    zip_file_set_mtime(archive.get(), entry, 0, 0);  // equal runs give equal files
  };
  for (const auto& [name, bytes] : arrays)
    add(name, zip_source_buffer(archive.get(), bytes.data(), bytes.size(), 0));
  for (const auto& [name, file] : files)
    add(name, zip_source_file(archive.get(), file.c_str(), 0, -1));
  if (zip_close(archive.get()) != 0) fail(zip_strerror(archive.get()));
  archive.release();
}

}  // namespace clothsim
