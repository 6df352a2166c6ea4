#include "clothsim/dynamics/spring_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <numeric>
#include <utility>

#include "block_kernels.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// Largest error of conjugate gradients in the energy norm, over the norm of the solution. The
/// largest error of a point is then some hundredth of the largest displacement, or less.
constexpr double gradients_precision = 1e-3;

/// Steps of conjugate gradients by the gains of which the error before them is estimated. The error
/// is then within 2e-3, of the stiffest cloths within 5e-3.
constexpr int gradients_delay = 5;

/// Factors::work() that takes as long as one block in a step of conjugate gradients. Measured for
/// grids of 10 x 10 to 100 x 100 points: 7 to 10, for a strip of 3 x 51: 4.
constexpr double work_per_block = 8.5;

template <typename Visitor>
void for_each_joint(const Cloth& cloth, Visitor&& visit) {
  for_each_spring(cloth, [&](const SpringRun&, int a, int b) { visit(a, b); });
  for_each_bent_pair(cloth, [&](double, int a, int b) { visit(a, b); });
  for_each_cell(cloth, [&](const Cell& cell) {
    for (std::size_t l = 0; l < cell.corners.size(); ++l) {
      for (std::size_t k = 0; k < l; ++k) visit(cell.corners[k], cell.corners[l]);
    }
  });
}

Eigen::Map<const Eigen::Matrix<double, 4, 3>> columns(const double* block) {
  return Eigen::Map<const Eigen::Matrix<double, 4, 3>>(block);
}

void add(const Matrix3& block, double* sum) {
  Eigen::Map<Eigen::Matrix<double, 4, 3>>(sum).topRows<3>() += block;
}

/// Piece of each point: joined ones have the same.
std::vector<int> pieces_of(const Cloth& cloth) {
  boost::disjoint_sets_with_storage<> joined(static_cast<std::size_t>(cloth.num_points()));
  for_each_joint(cloth, [&](int a, int b) { joined.union_set(a, b); });
  std::vector<int> pieces;
  for (int i = 0; i < cloth.num_points(); ++i) {
    pieces.push_back(static_cast<int>(joined.find_set(i)));
  }
  return pieces;
}

}  // namespace

void SpringSystem::begin(const Cloth& cloth) {
  Joints joints{{cloth.num_points(), static_cast<int>(cloth.springs.size()),
                 static_cast<int>(cloth.bends.size())}};
  for (const SpringRun& run : cloth.springs) joints.push_back({run.first, run.offset, run.count});
  for (const BendRun& run : cloth.bends) {
    joints.push_back({run.first, run.a, run.count});
    joints.push_back({run.first, run.b, run.count});
  }
  for (const CellRun& run : cloth.cells) {
    joints.push_back({run.first, run.a, run.count});
    joints.push_back({run.first, run.b, run.count});
  }
  if (cloth.is_mesh()) {
    for (const auto& pair : cloth.triangle_fabric->pairs) joints.push_back({pair.i, pair.j, 1});
  }
  if (joints != joints_) {
    joints_ = std::move(joints);
    lay_out(cloth);
  }
  std::fill(blocks_.begin(), blocks_.end(), 0.0);
}

void SpringSystem::lay_out(const Cloth& cloth) {
  lay_out_rows(cloth);
  const std::size_t n = points_.size();
  std::vector<std::vector<int>> later(n);
  for_each_joint(cloth,
                 [&](int a, int b) { later[row_of(a)].push_back(static_cast<int>(row_of(b))); });
  firsts_.clear();
  ends_.clear();
  for (std::size_t a = 0; a < n; ++a) {
    std::vector<int>& list = later[a];
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    firsts_.push_back(static_cast<int>(ends_.size()));
    ends_.push_back(static_cast<int>(a));
    ends_.insert(ends_.end(), list.begin(), list.end());
  }
  firsts_.push_back(static_cast<int>(ends_.size()));

  ranks_.clear();
  for_each_joint(cloth, [&](int a, int b) {
    const std::vector<int>& list = later[row_of(a)];
    const auto place = std::lower_bound(list.begin(), list.end(), static_cast<int>(row_of(b)));
    ranks_.push_back(static_cast<int>(place - list.begin()));
  });
  blocks_.assign(block_size * ends_.size(), 0);
  lay_out_matrix();
}

/// Orders the points piece by piece, ascending.
void SpringSystem::lay_out_rows(const Cloth& cloth) {
  const std::vector<int> piece_of = pieces_of(cloth);
  points_.resize(piece_of.size());
  std::iota(points_.begin(), points_.end(), 0);
  std::stable_sort(points_.begin(), points_.end(), [&](int a, int b) {
    return piece_of[static_cast<std::size_t>(a)] < piece_of[static_cast<std::size_t>(b)];
  });
  rows_.resize(points_.size());
  pieces_.clear();
  for (int row = 0; row < cloth.num_points(); ++row) {
    const auto point = static_cast<std::size_t>(points_[static_cast<std::size_t>(row)]);
    rows_[point] = row;
    if (row == 0 ||
        piece_of[point] !=
            piece_of[static_cast<std::size_t>(points_[static_cast<std::size_t>(row) - 1])]) {
      pieces_.push_back({row, row});
    }
    pieces_.back().end = row + 1;
  }
}

Eigen::VectorXd SpringSystem::in_rows(const Points& points) const {
  Eigen::Matrix<double, 4, Eigen::Dynamic> fours(4, points.rows());
  fours.topRows<3>() = points(points_, Eigen::all).transpose();
  fours.row(3).setZero();
  return fours.reshaped();
}

Points SpringSystem::by_points(const Eigen::VectorXd& rows) const {
  const auto size = static_cast<Eigen::Index>(points_.size());
  return rows.reshaped(4, size).topRows<3>()(Eigen::all, rows_).transpose();
}

double* SpringSystem::block(int number) { return blocks_.data() + block_size * number; }
const double* SpringSystem::block(int number) const { return blocks_.data() + block_size * number; }

void SpringSystem::add_to_point(int i, const Matrix3& block_of_point) {
  add(block_of_point, block(firsts_[row_of(i)]));
}

void SpringSystem::add_pair(int id, int a, int b, const Matrix3& block_of_pair) {
  add_to_point(a, block_of_pair);
  add_to_point(b, block_of_pair);
  add_between(id, a, -block_of_pair);
}

void SpringSystem::add_between(int id, int a, const Matrix3& block_of_pair) {
  const int rank = ranks_[static_cast<std::size_t>(id)];
  add(block_of_pair, block(firsts_[row_of(a)] + 1 + rank));
}

bool SpringSystem::solve(const Points& rhs, double negligible, Points& solution) {
  const bool by_gradients =
      max_steps_ > gradients_delay && solve_by_gradients(rhs, negligible, max_steps_, solution);
  return by_gradients || solve_by_factors(rhs, solution);
}

/// Sets the inverses of the points' blocks. False where one is not positive definite.
bool SpringSystem::invert_points() {
  const std::size_t points = firsts_.size() - 1;
  inverses_.assign(block_size * points, 0);
  for (std::size_t i = 0; i < points; ++i) {
    const Eigen::LLT<Matrix3> own(columns(block(firsts_[i])).topRows<3>());
    const Matrix3 inverse = own.solve(Matrix3::Identity());
    if (own.info() != Eigen::Success || !inverse.allFinite()) return false;
    add(inverse, inverses_.data() + block_size * i);
  }
  return true;
}

bool SpringSystem::solve_by_gradients(const Points& rhs, double negligible, int max_steps,
                                      Points& solution) {
  if (!invert_points()) return false;
  const Eigen::VectorXd right = in_rows(rhs);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size());
  for (const Piece& piece : pieces_) {
    if (!solve_piece(piece, negligible, max_steps, right, x)) return false;
  }
  solution = by_points(x);
  return solution.allFinite();
}

bool SpringSystem::solve_piece(const Piece& piece, double negligible, int max_steps,
                               const Eigen::VectorXd& rhs, Eigen::VectorXd& x) const {
  const int begin = 4 * piece.begin, size = 4 * (piece.end - piece.begin);
  const auto of_piece = [&](auto& vector) { return vector.segment(begin, size); };
  Eigen::VectorXd residual = rhs, conditioned(rhs.size()), product(rhs.size());
  const auto condition = [&] {
    multiply_points(piece.begin, piece.end, inverses_.data(), residual.data(), conditioned.data());
    return of_piece(residual).dot(of_piece(conditioned));
  };
  double square = condition();
  Eigen::VectorXd direction = conditioned;
  // A step takes its gain off the square of the error's energy norm (Hestenes & Stiefel 1952), so
  // the gains of the last steps are a lower bound of that square before them (Strakos & Tichy
  // 2002).
  std::array<double, gradients_delay> gains;
  gains.fill(infinity);
  double all_gains = 0;
  for (int step = 0; square > 0; ++step) {
    const double last_gains = std::accumulate(gains.begin(), gains.end(), 0.0);
    if (last_gains <= std::max(negligible, gradients_precision * gradients_precision * all_gains)) {
      return true;
    }
    if (step == max_steps) return false;
    multiply(piece.begin, piece.end, firsts_.data(), ends_.data(), blocks_.data(), direction.data(),
             product.data());
    const double curvature = of_piece(direction).dot(of_piece(product));
    if (!(curvature > 0 && std::isfinite(curvature))) return false;
    const double share = square / curvature;
    of_piece(x) += share * of_piece(direction);
    of_piece(residual) -= share * of_piece(product);
    const double last = square;
    square = condition();
    of_piece(direction) = of_piece(conditioned) + square / last * of_piece(direction);
    gains[static_cast<std::size_t>(step % gradients_delay)] = share * last;
    all_gains += share * last;
  }
  return square == 0;
}

/// Calls visit(row, column, value) for the lower half, column by column.
template <typename Visitor>
void SpringSystem::for_each_entry(Visitor&& visit) const {
  for (std::size_t a = 0; a + 1 < firsts_.size(); ++a) {
    for (int c = 0; c < 3; ++c) {
      for (int k = firsts_[a]; k < firsts_[a + 1]; ++k) {
        const int end = ends_[static_cast<std::size_t>(k)];
        const double* const column = block(k) + 4 * c;
        for (int r = k == firsts_[a] ? c : 0; r < 3; ++r) {
          visit(3 * end + r, 3 * static_cast<int>(a) + c, column[r]);
        }
      }
    }
  }
}

void SpringSystem::lay_out_matrix() {
  std::vector<Eigen::Triplet<double>> entries;
  for_each_entry(
      [&](int row, int column, double value) { entries.emplace_back(row, column, value); });
  const auto size = static_cast<Eigen::Index>(3 * (firsts_.size() - 1));
  matrix_.resize(size, size);
  matrix_.setFromTriplets(entries.begin(), entries.end());
  factors_.analyzePattern(matrix_);
  // Before a factorisation, which may leave other counts.
  max_steps_ =
      static_cast<int>(factors_.work() / (work_per_block * static_cast<double>(ends_.size())));
}

bool SpringSystem::solve_by_factors(const Points& rhs, Points& solution) {
  double* next = matrix_.valuePtr();
  for_each_entry([&](int, int, double value) { *next++ = value; });
  factors_.factorize(matrix_);
  if (factors_.info() != Eigen::Success || !(factors_.vectorD().array() > 0).all()) return false;
  const Eigen::Matrix<double, 3, Eigen::Dynamic> right = rhs(points_, Eigen::all).transpose();
  const Eigen::VectorXd x = factors_.solve(right.reshaped());
  solution = x.reshaped(3, rhs.rows())(Eigen::all, rows_).transpose();
  return solution.allFinite();
}

}  // namespace clothsim
