// Pairs kept over some looks, while the cloth moves little within itself.

#include <algorithm>
#include <array>
#include <cmath>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "near_pairs_impl.h"

namespace clothsim {
namespace {

/// What is kept reaches so many margins: with one it serves fewer looks, with four it takes longer
/// to find than it saves.
constexpr double kept_share = 2;

/// Squares of the lengths of to - from - common, the largest.
CLOTHSIM_TARGET_CLONES
double longest_squared(Eigen::Index count, const double* from, const double* to,
                       const double* common) {
  constexpr Eigen::Index lanes = num_lanes;
  std::array<double, lanes> longest{};
  const double *x0 = from, *y0 = from + count, *z0 = from + 2 * count;
  const double *x1 = to, *y1 = to + count, *z1 = to + 2 * count;
  const double cx = common[0], cy = common[1], cz = common[2];
  const auto squared = [&](Eigen::Index i) {
    const double x = x1[i] - x0[i] - cx, y = y1[i] - y0[i] - cy, z = z1[i] - z0[i] - cz;
    return x * x + y * y + z * z;
  };
  Eigen::Index i = 0;
  for (; i + lanes <= count; i += lanes) {
    for (Eigen::Index k = 0; k < lanes; ++k) {
      const double s = squared(i + k);
      longest[static_cast<std::size_t>(k)] =
          s > longest[static_cast<std::size_t>(k)] ? s : longest[static_cast<std::size_t>(k)];
    }
  }
  for (; i < count; ++i) longest[0] = std::max(longest[0], squared(i));
  return *std::max_element(longest.begin(), longest.end());
}

}  // namespace

double NearPairs::Impl::kept_reach() const { return kept_share * margin; }

double NearPairs::Impl::spread(const Points& from, const Points& to) {
  const Eigen::RowVector3d common = to.colwise().mean() - from.colwise().mean();
  return std::sqrt(longest_squared(from.rows(), from.data(), to.data(), common.data()));
}

/// How much nearer two features may have come since they were kept [m]; infinity: none are kept.
double NearPairs::Impl::nearer_than_kept(const Points& positions) const {
  return kept_at.rows() == 0 ? infinity : 2 * spread(kept_at, positions);
}

/// Sees to it that all pairs are kept whose gap may be within `step` at `positions`. Returns within
/// what they were then; none where the step leaves no room for further looks.
std::optional<double> NearPairs::Impl::keep(const Cloth& cloth, const Query& query, double step,
                                            const Workers& workers) {
  const bool has_room = step * looks <= kept_reach();
  const double needed = step + nearer_than_kept(query.positions);
  if (has_room && needed <= kept_reach()) return needed;
  kept_at.resize(0, 3);
  if (!has_room) return {};
  advance(cloth, query.positions, workers);
  for (std::vector<Kept>& pairs : kept) pairs.clear();
  std::size_t place = 0;  // what is found is in the order of keys
  const Query all{query.positions, nullptr, infinity, query.budget, {kept_reach(), kept_reach()}};
  for (const NearPair& n : look(all, workers)) {
    kept[n.pair.edges()].push_back(
        {n.separation.distance - n.pair.nearest, n.key, place++, n.pair});
  }
  if (!query.spend(0)) return {};
  const auto nearer = [](const Kept& a, const Kept& b) {
    return a.gap < b.gap || (a.gap == b.gap && a.key < b.key);
  };
  for (std::vector<Kept>& pairs : kept) std::sort(pairs.begin(), pairs.end(), nearer);
  kept_at = query.positions;
  return step;
}

/// What is asked for of the pairs kept whose gap was within `reach` then.
const std::vector<NearPair>& NearPairs::Impl::look_at_kept(const Query& query, double reach) {
  near.clear();
  asked_for.assign(kept[0].size() + kept[1].size(), nullptr);
  std::size_t count = 0;
  for (const bool edges : {false, true}) {
    Distances distances(edges);
    const Kept* next = kept[edges].data();
    const Kept* const end = next + kept[edges].size();
    while (next != end && next->gap <= reach) {
      const Kept* const first = next;
      for (; next != end && next->gap <= reach && distances.room() > 0; ++next) {
        distances.add(next->pair.points);
      }
      if (!query.spend(distances.size())) return near;
      distances.measure(query.positions);
      for (std::size_t k = 0; k < distances.size(); ++k) {
        const SurfacePair& pair = first[k].pair;
        if (is_asked_for(query, query.reach[true], distances, k, pair.points,
                         rounded_up(pair.nearest))) {
          asked_for[first[k].place] = first + k;
          ++count;
        }
      }
      distances.clear();
    }
  }
  if (!query.spend(WorkBudget::pair_found * count)) return near;
  for (const Kept* of : asked_for) {
    if (!of) continue;
    const Separation s = separation(of->pair, query.positions);
    if (s.distance <= query.distance) near.push_back({of->key, of->pair, s});
  }
  return near;
}

}  // namespace clothsim
