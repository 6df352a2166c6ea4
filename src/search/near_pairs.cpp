#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

#include "near_pairs_impl.h"

namespace clothsim {
namespace {

/// Farthest that two features which approach each other are looked at, of the least distance at
/// rest.
constexpr double margin_share = 0.12;

}  // namespace

NearPairs::Impl::Impl(const Cloth& cloth)
    : mesh(cloth),
      nearest(cloth),
      feature_pairs(mesh),
      patches(cut_into_patches(cloth, patch_cells)),
      patch_columns((mesh.cell_columns + patch_cells - 1) / patch_cells),
      outlines(patches.size()) {
  const Points& x = cloth.rest_positions;
  const double along_row = (x.row(1) - x.row(0)).norm();
  const double along_column = (x.row(cloth.columns) - x.row(0)).norm();
  spacing = std::min(along_row, along_column);
  // A point and the long side of a triangle; two diagonals side by side are as far apart.
  least_rest_distance = along_row * along_column / std::hypot(along_row, along_column);
  contact = 2 * cloth.thickness;
  margin = margin_share * least_rest_distance;
  boxes.resize(patches.size());
  gradients.resize(patches.size());
}

/// Brings what is known of patches up to date.
void NearPairs::Impl::advance(const Cloth& cloth, const Points& positions, const Workers& workers) {
  if (last.rows() > 0 && last == positions) return;
  outline(cloth, positions, workers);
  if (last.rows() > 0) {
    motions.follow(patches, last, positions, workers);
    workers.share(
        static_cast<int>(patch_pairs.size()),
        [&](int begin, int end) {
          for (int k = begin; k < end; ++k) {
            PatchPair& pair = patch_pairs[static_cast<std::size_t>(k)];
            pair.moved += motions.between(pair.p, pair.q);
          }
        },
        Workers::dear);
  }
  last = positions;
  const double most_spread = patch_cells * spacing;
  if (paired_at.rows() == 0 || 2 * spread(paired_at, positions) > most_spread) {
    pair_patches(contact + kept_reach() + most_spread);
    paired_at = positions;
  }
}

/// Where patches and cells are.
void NearPairs::Impl::outline(const Cloth& cloth, const Points& positions, const Workers& workers) {
  const int columns = mesh.cell_columns;
  workers.share(
      static_cast<int>(patches.size()),
      [&](int begin, int end) {
        for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) {
          const Patch& patch = patches[p];
          const int first = patch.cells.front();
          boxes[p] = around(positions, patch.points);
          gradients[p] = gradient_bounds(cloth, positions, first % columns, first / columns,
                                         patch.columns - 1, patch.rows - 1);
          outlines.update(p, patch, positions);
        }
      },
      Workers::dear);
}

/// Are they so near on the cloth that they may touch at rest, but for the neighbours' share?
bool NearPairs::Impl::are_neighbours(int p, int q) const {
  const std::vector<int>& of_p = patches[static_cast<std::size_t>(p)].cells;
  const std::vector<int>& of_q = patches[static_cast<std::size_t>(q)].cells;
  const int columns = mesh.cell_columns;
  const double window = std::ceil(contact / (NearestDistances::neighbour_share * spacing));
  const auto gap = [](int a_first, int a_last, int b_first, int b_last) {
    return std::max(b_first - a_last, a_first - b_last);
  };
  return gap(of_p.front() % columns, of_p.back() % columns, of_q.front() % columns,
             of_q.back() % columns) <= window &&
         gap(of_p.front() / columns, of_p.back() / columns, of_q.front() / columns,
             of_q.back() / columns) <= window;
}

/// Pairs the patches whose boxes are within `reach`; those that were paired before go on.
void NearPairs::Impl::pair_patches(double reach) {
  std::vector<Box> wider = boxes;
  for (Box& box : wider) {
    box.min().array() -= reach / 2;
    box.max().array() += reach / 2;
  }
  std::vector<PatchPair> pairs;
  const auto add = [&](int p, int q) { pairs.push_back({p, q, are_neighbours(p, q)}); };
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) add(p, p);
  BoxTree(wider).visit_overlaps(add);
  const auto before = [](const PatchPair& a, const PatchPair& b) {
    return a.p < b.p || (a.p == b.p && a.q < b.q);
  };
  std::sort(pairs.begin(), pairs.end(), before);

  auto old = patch_pairs.begin();
  for (PatchPair& pair : pairs) {
    while (old != patch_pairs.end() && before(*old, pair)) ++old;
    if (old != patch_pairs.end() && old->p == pair.p && old->q == pair.q) pair = std::move(*old);
  }
  patch_pairs = std::move(pairs);
}

/// What is asked for, of all patches.
const std::vector<NearPair>& NearPairs::Impl::look(const Query& query, const Workers& workers) {
  scratches.resize(static_cast<std::size_t>(workers.threads() * Workers::uneven));
  for (Scratch& scratch : scratches) scratch.band = -1;
  std::atomic<std::size_t> used{0};
  workers.share(
      static_cast<int>(patch_pairs.size()),
      [&](int begin, int end) {
        Scratch& scratch = scratches[used++];
        scratch.band = begin;
        for (int k = begin; k < end; ++k) {
          PatchPair& pair = patch_pairs[static_cast<std::size_t>(k)];
          const double within = query.within(pair);
          if (!query.spend(1)) break;  // what was begun is taken back
          if (std::min(pair.wake_at[0], pair.wake_at[1]) > pair.moved + within) continue;
          if (pair.moved + within > pair.list_until) {
            const double gap = gap_of_patches(pair);
            if (gap > within) {
              pair.wake_at.fill(pair.moved + gap);
              continue;
            }
            seek(query, pair, scratch);
          } else {
            scratch.awake.push_back(&pair);
          }
        }
        for (const bool edges : {false, true}) {
          for (std::size_t list = 0; list < FeaturePairs::num_lists; ++list) {
            measure_cells(query, edges, list, scratch);
          }
          look_at_lists(query, edges, scratch);
        }
        keep_found(query, scratch);
        scratch.awake.clear();
      },
      Workers::dear, Workers::uneven);

  return collect();
}

/// What has been found in all bands, in order.
const std::vector<NearPair>& NearPairs::Impl::collect() {
  std::vector<Scratch*> order;
  for (Scratch& scratch : scratches) order.push_back(&scratch);
  std::sort(order.begin(), order.end(),
            [](const Scratch* a, const Scratch* b) { return a->band < b->band; });
  near.clear();
  for (Scratch* scratch : order) {
    if (near.empty()) {
      near.swap(scratch->near);
    } else {
      near.insert(near.end(), scratch->near.begin(), scratch->near.end());
    }
    scratch->near.clear();
  }
  return near;
}

NearPairs::NearPairs(const Cloth& cloth) : impl_(std::make_unique<Impl>(cloth)) {}
NearPairs::~NearPairs() = default;
NearPairs::NearPairs(const NearPairs& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
NearPairs::NearPairs(NearPairs&&) noexcept = default;
NearPairs& NearPairs::operator=(NearPairs other) noexcept {
  impl_.swap(other.impl_);
  return *this;
}

const std::vector<NearPair>& NearPairs::approaching(const Cloth& cloth, const Points& positions,
                                                    const Points& ahead, const Workers& workers,
                                                    WorkBudget* budget) {
  Impl& impl = *impl_;
  const Impl::Query query{positions, &ahead, Impl::infinity, budget, {margin(), margin()}};
  const double step = std::max(2 * Impl::spread(positions, ahead), least_margin());
  if (const std::optional<double> needed = impl.keep(cloth, query, step, workers)) {
    return impl.look_at_kept(query, *needed);
  }
  impl.advance(cloth, positions, workers);
  return impl.look(query, workers);
}

const std::vector<NearPair>& NearPairs::within(const Cloth& cloth, const Points& positions,
                                               double distance, const Workers& workers,
                                               WorkBudget* budget) {
  assert(distance <= reach());
  Impl& impl = *impl_;
  const double most_gap = distance - least_nearest();
  const double most_far_gap = distance - impl.nearest.least_far();
  const Impl::Query query{positions, nullptr, distance, budget, {most_far_gap, most_gap}};
  const double needed = most_gap + impl.nearer_than_kept(positions);
  if (needed <= impl.kept_reach()) return impl.look_at_kept(query, needed);
  impl.advance(cloth, positions, workers);
  return impl.look(query, workers);
}

double NearPairs::least_margin() const { return impl_->least_margin(); }
double NearPairs::margin() const { return impl_->margin; }
double NearPairs::least_nearest() const { return impl_->nearest.least(); }
const SurfaceMesh& NearPairs::mesh() const { return impl_->mesh; }

}  // namespace clothsim
