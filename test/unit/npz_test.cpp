// NPZ files, also as NumPy itself writes and reads them.

#include "clothsim/model/npz.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "clothsim/model/errors.h"
#include "temporary_folder.h"

namespace clothsim::npz_test {
namespace {

class Npz : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  /// Runs a line of Python with NumPy in the folder; returns its output.
  std::string python(const std::string& line) const {
    const std::string command = "cd " + folder_.path().string() +
                                " && /usr/bin/python3 -c \"import numpy as np; " + line +
                                "\" > out 2>&1";
    const int status = std::system(command.c_str());
    std::ostringstream text;
    text << std::ifstream(path("out")).rdbuf();
    EXPECT_EQ(status, 0) << text.str();
    return text.str();
  }

  std::string refusal(const std::string& name) const {
    try {
      read_npz(path(name));
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  }

  const test::TemporaryFolder folder_{"npz"};
};

TEST_F(Npz, ReadsBackTheSameBits) {
  const Points points = Points::Random(7, 3) * 1e-3;
  write_npz(path("a.npz"), {{"p", to_npy(to_array(points))},
                            {"one", to_npy(NumberArray{{}, {1.0 / 3}})},
                            {"none", to_npy(NumberArray{{0}, {}})},
                            {"i", to_npy({2, 3}, {1, 2, 3, 4, 5, -6})}});
  const auto arrays = read_npz(path("a.npz"));
  ASSERT_EQ(arrays.size(), 4u);
  EXPECT_EQ(arrays.at("p").shape, (std::vector<std::size_t>{7, 3}));
  for (int i = 0; i < 7; ++i) {
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(arrays.at("p").values[static_cast<std::size_t>(3 * i + k)], points(i, k));
  }
  EXPECT_TRUE(arrays.at("one").shape.empty());
  EXPECT_EQ(arrays.at("one").values, std::vector<double>{1.0 / 3});
  EXPECT_TRUE(arrays.at("none").values.empty());
  EXPECT_EQ(arrays.at("i").values, (std::vector<double>{1, 2, 3, 4, 5, -6}));
}

TEST_F(Npz, NumPyReadsIt) {
  GrowingNpy grows(path("g.part"), {2});
  for (const double x : {0.0, 1.0, 2.0}) grows.append({x, 0.1});
  grows.flush();
  write_npz(path("a.npz"), {{"i", to_npy({2, 1}, {7, -8})}}, {{"g", grows.path()}});
  EXPECT_EQ(python("a = np.load('a.npz'); print(a['g'].tolist(), a['i'].tolist(), a['i'].dtype)"),
            "[[0.0, 0.1], [1.0, 0.1], [2.0, 0.1]] [[7], [-8]] int32\n");
}

TEST_F(Npz, ReadsWhatNumPyWrites) {
  python(
      "np.savez_compressed('a', f=np.arange(6, dtype='f4').reshape(2, 3), "
      "i=np.array([3, -4]), d=np.array(0.1))");
  const auto arrays = read_npz(path("a.npz"));
  EXPECT_EQ(arrays.at("f").values, (std::vector<double>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(arrays.at("f").shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(arrays.at("i").values, (std::vector<double>{3, -4}));
  EXPECT_EQ(arrays.at("d").values, std::vector<double>{0.1});
}

TEST_F(Npz, RefusesWhatIsNone) {
  EXPECT_NE(refusal("nothing.npz").find("no regular file"), std::string::npos);
  std::ofstream(path("text.npz")) << "x,y\n1,2\n";
  EXPECT_NE(refusal("text.npz").find("expected an NPZ file"), std::string::npos);
  python(
      "np.savez('word', w=np.array(['a', 'b'])); np.savez('turned', t=np.ones((2, 3), order='F')); "
      "np.savez('object', o=np.array([{}], dtype=object))");
  EXPECT_NE(refusal("word.npz").find("w: got numbers of type <U1"), std::string::npos);
  EXPECT_NE(refusal("turned.npz").find("t: got no simple array in C order"), std::string::npos);
  EXPECT_NE(refusal("object.npz").find("o: got"), std::string::npos);

  // Headers with false sizes.
  const std::string good = to_npy(NumberArray{{3}, {1, 2, 3}});
  std::string longer = good, huge = good, cut = good.substr(0, 40);
  longer.replace(longer.find("(3, )"), 5, "(4, )");
  huge.replace(huge.find("(3, )"), 5, "(9999999999999999999, 9, )").resize(good.size());
  for (const std::string& bytes : {longer, huge, cut, std::string("NUMPY"), std::string()}) {
    write_npz(path("bad.npz"), {{"x", bytes}});
    EXPECT_NE(refusal("bad.npz").find("x: got"), std::string::npos) << bytes.size();
  }
}

TEST_F(Npz, IsWholeOrNotThere) {
  EXPECT_THROW(write_npz(path("no/where.npz"), {{"x", to_npy(NumberArray{{1}, {1}})}}),
               std::runtime_error);
  EXPECT_THROW(GrowingNpy(path("no/where"), {1}), std::runtime_error);
  { GrowingNpy grows(path("g.part"), {1}); }
  EXPECT_FALSE(std::filesystem::exists(path("g.part")));
}

}  // namespace
}  // namespace clothsim::npz_test
