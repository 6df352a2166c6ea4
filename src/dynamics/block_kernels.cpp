#include "block_kernels.h"

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

Half& four_at(double* numbers) { return *reinterpret_cast<Half*>(numbers); }

}  // namespace

CLOTHSIM_TARGET_CLONES
void multiply(int begin, int end, const int* firsts, const int* ends, const double* blocks,
              const double* vector, double* product) {
  for (int a = begin; a < end; ++a) four_at(product + 4 * a) = Half{};
  for (int a = begin; a < end; ++a) {
    const double* block = blocks + block_size * firsts[a];
    const double x = vector[4 * a], y = vector[4 * a + 1], z = vector[4 * a + 2];
    Half sum = four_at(product + 4 * a) + x * half_at(block) + y * half_at(block + 4) +
               z * half_at(block + 8);
    // Lane by lane, so that each point needs one sum over lanes alone.
    Half by_column[3] = {};
    for (int k = firsts[a] + 1; k < firsts[a + 1]; ++k) {
      block += block_size;
      const Half& of_b = half_at(vector + 4 * ends[k]);
      Half& of_other = four_at(product + 4 * ends[k]);
      of_other += x * half_at(block) + y * half_at(block + 4) + z * half_at(block + 8);
      for (int c = 0; c < 3; ++c) by_column[c] += half_at(block + 4 * c) * of_b;
    }
    for (int c = 0; c < 3; ++c) sum[c] += by_column[c][0] + by_column[c][1] + by_column[c][2];
    four_at(product + 4 * a) = sum;
  }
}

CLOTHSIM_TARGET_CLONES
void multiply_points(int begin, int end, const double* blocks, const double* vector,
                     double* product) {
  for (int i = begin; i < end; ++i) {
    const double* block = blocks + block_size * i;
    four_at(product + 4 * i) = vector[4 * i] * half_at(block) +
                               vector[4 * i + 1] * half_at(block + 4) +
                               vector[4 * i + 2] * half_at(block + 8);
  }
}

}  // namespace clothsim
