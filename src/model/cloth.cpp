#include "clothsim/model/cloth.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace clothsim {
namespace {

/// The first band with this offset and rest length, added if there is none.
PairBand& band_of(int offset, std::optional<double> rest_length, int num_points,
                  std::vector<PairBand>& bands) {
  const auto found = std::find_if(bands.begin(), bands.end(), [&](const PairBand& band) {
    return band.offset == offset && (!rest_length || band.rest_length == *rest_length);
  });
  if (found != bands.end()) return *found;
  bands.push_back({offset, rest_length.value_or(0), {}, Scalars::Zero(num_points - offset)});
  return bands.back();
}

/// |e . x|^2 of coefficients e whose sum is zero is the sum of -e_i e_j |x_i - x_j|^2 over pairs.
void add_pairs(const BendRun& run, int num_points, std::vector<PairBand>& bands) {
  const auto add = [&](int from, int to, double coefficient) {
    if (from == to) return;
    const int offset = std::abs(to - from);
    band_of(offset, {}, num_points, bands)
        .bend.segment(run.first + std::min(from, to), run.count) +=
        Scalars::Constant(run.count, coefficient * run.stiffness);
  };
  const int end = run.a + run.b;
  for (const int middle : {run.a, run.b}) {
    add(0, middle, 1);
    add(middle, end, 1);
  }
  add(0, end, -1);
  add(run.a, run.b, -1);
}

CellBand& cell_band_of(const CellRun& run, int num_points, std::vector<CellBand>& bands) {
  const auto found = std::find_if(bands.begin(), bands.end(), [&](const CellBand& band) {
    return band.a == run.a && band.b == run.b && band.strain == run.strain;
  });
  if (found != bands.end()) return *found;
  bands.push_back({run.a, run.b, run.strain, Scalars::Zero(num_points - run.a - run.b)});
  return bands.back();
}

BendBand& bend_band_of(const BendRun& run, int num_points, std::vector<BendBand>& bands) {
  const auto found = std::find_if(bands.begin(), bands.end(), [&](const BendBand& band) {
    return band.a == run.a && band.b == run.b;
  });
  if (found != bands.end()) return *found;
  bands.push_back({run.a, run.b, Scalars::Zero(num_points - run.a - run.b)});
  return bands.back();
}

}  // namespace

int Cloth::num_springs() const {
  int count = 0;
  for (const SpringRun& run : springs) count += run.count;
  return count;
}

std::size_t Cloth::cloth_of(int point) const {
  const auto next = std::upper_bound(first_points.begin(), first_points.end(), point);
  return next == first_points.begin() ? 0
                                      : static_cast<std::size_t>(next - first_points.begin() - 1);
}

bool Cloth::is_limited() const {
  const auto is_set = [](const std::optional<double>& limit) { return limit.has_value(); };
  return strain_limit && std::all_of(strain_limits.begin(), strain_limits.end(), is_set);
}

double Cloth::friction_between(int i, int j) const {
  const double a = friction_at(i), b = friction_at(j);
  return a == b ? a : std::sqrt(a * b);  // the square's root is rounded
}

double Cloth::min_thickness() const {
  return thicknesses.size() > 0 ? thicknesses.minCoeff() : thickness;
}

bool has_same_thickness(const Cloth& a, const Cloth& b) {
  return a.thickness == b.thickness && a.thicknesses.size() == b.thicknesses.size() &&
         a.thicknesses == b.thicknesses;
}

int Cloth::num_bends() const {
  if (is_mesh()) return static_cast<int>(triangle_fabric->bends.size());
  int count = 0;
  for (const BendRun& run : bends) count += run.count;
  return count;
}

int Cloth::num_links() const {
  int count = num_bends();
  for (const SpringRun& run : springs) count += run.stiffness > 0 ? run.count : 0;
  for (const CellRun& run : cells) count += run.count;
  return count;
}

void set_bands(Cloth& cloth) {
  const int n = cloth.num_points();
  cloth.pairs.clear();
  cloth.bend_bands.clear();
  cloth.cell_bands.clear();
  for (const SpringRun& run : cloth.springs) {
    if (run.stiffness == 0) continue;
    PairBand& band = band_of(run.offset, run.rest_length, n, cloth.pairs);
    if (band.spring.size() == 0) band.spring.setZero(n - run.offset);
    band.spring.segment(run.first, run.count).array() += run.stiffness;
  }
  for (const BendRun& run : cloth.bends) {
    add_pairs(run, n, cloth.pairs);
    bend_band_of(run, n, cloth.bend_bands).stiffness.segment(run.first, run.count).array() +=
        run.stiffness;
  }
  for (const CellRun& run : cloth.cells) {
    cell_band_of(run, n, cloth.cell_bands).stiffness.segment(run.first, run.count).array() +=
        run.stiffness;
  }
}

}  // namespace clothsim
