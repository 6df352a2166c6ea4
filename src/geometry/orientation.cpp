#include "clothsim/geometry/orientation.h"

#include <array>
#include <cfloat>
#include <cmath>

// Exact only where every operation is rounded once, to the nearest double.
static_assert(FLT_EVAL_METHOD == 0, "orientation() needs arithmetic in double");
#ifdef __FAST_MATH__
#error "orientation() needs IEEE arithmetic: build without -ffast-math"
#endif

namespace clothsim {
namespace {

/// Half the distance from 1 to the next double.
constexpr double epsilon = DBL_EPSILON / 2;

/// Bound on the rounding error of the determinant, as a share of the sum of its terms' magnitudes.
/// Shewchuk 1997, figure 21.
constexpr double error_share = (7 + 56 * epsilon) * epsilon;

struct Parts {
  double value;
  double error;
};

/// a + b = value + error, exactly (Knuth).
Parts two_sum(double a, double b) {
  const double value = a + b;
  const double of_b = value - a;
  return {value, (a - (value - of_b)) + (b - of_b)};
}

/// a * b = value + error, exactly.
Parts two_product(double a, double b) {
  const double value = a * b;
  return {value, std::fma(a, b, -value)};
}

/// A number without rounding error: a sum of doubles without common bits, the least first. Zeros
/// are left out, so the greatest part has the sign of the sum. Shewchuk 1997, section 2.
class Expansion {
 public:
  static Expansion difference(double a, double b) {
    const Parts d = two_sum(a, -b);
    Expansion result;
    result.append(d.error);
    result.append(d.value);
    return result;
  }

  int sign() const {
    if (size_ == 0) return 0;
    return last() > 0 ? 1 : -1;
  }

  /// FAST-EXPANSION-SUM.
  friend Expansion operator+(const Expansion& e, const Expansion& f) {
    std::size_t i = 0, j = 0;
    const auto next = [&] {
      const bool from_e =
          j == f.size_ || (i < e.size_ && std::abs(e.parts_[i]) < std::abs(f.parts_[j]));
      return from_e ? e.parts_[i++] : f.parts_[j++];
    };
    Expansion result;
    const std::size_t size = e.size_ + f.size_;
    if (size == 0) return result;
    double carry = next();
    while (i + j < size) {
      const Parts sum = two_sum(carry, next());
      result.append(sum.error);
      carry = sum.value;
    }
    result.append(carry);
    return result;
  }

  friend Expansion operator-(const Expansion& e, Expansion f) {
    for (std::size_t i = 0; i < f.size_; ++i) f.parts_[i] = -f.parts_[i];
    return e + f;
  }

  /// SCALE-EXPANSION.
  friend Expansion operator*(const Expansion& e, double factor) {
    Expansion result;
    if (e.size_ == 0) return result;
    const Parts first = two_product(e.parts_[0], factor);
    result.append(first.error);
    double carry = first.value;
    for (std::size_t i = 1; i < e.size_; ++i) {
      const Parts product = two_product(e.parts_[i], factor);
      const Parts low = two_sum(carry, product.error);
      result.append(low.error);
      const Parts high = two_sum(product.value, low.value);
      result.append(high.error);
      carry = high.value;
    }
    result.append(carry);
    return result;
  }

  friend Expansion operator*(const Expansion& e, const Expansion& f) {
    Expansion result;
    for (std::size_t i = 0; i < f.size_; ++i) result = result + e * f.parts_[i];
    return result;
  }

 private:
  /// The most parts of a determinant. A sum has as many parts as both operands together, a product
  /// twice the product of both counts. So a difference of coordinates has 2, a product of two 8,
  /// the difference of two such products 16, times a difference 64, and the sum of three of these:
  enum : std::size_t { capacity = 192 };

  double last() const { return parts_[size_ - 1]; }
  void append(double part) {
    if (part != 0) parts_[size_++] = part;
  }

  std::array<double, capacity> parts_;  // the first size_ are set
  std::size_t size_ = 0;
};

int exact_orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const auto difference = [&a](const Vector3& p, int axis) {
    return Expansion::difference(p[axis], a[axis]);
  };
  const Expansion bx = difference(b, 0), by = difference(b, 1), bz = difference(b, 2);
  const Expansion cx = difference(c, 0), cy = difference(c, 1), cz = difference(c, 2);
  const Expansion dx = difference(d, 0), dy = difference(d, 1), dz = difference(d, 2);
  const Expansion determinant =
      (by * cz - bz * cy) * dx + (bz * cx - bx * cz) * dy + (bx * cy - by * cx) * dz;
  return determinant.sign();
}

}  // namespace

int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const double bx = b.x() - a.x(), by = b.y() - a.y(), bz = b.z() - a.z();
  const double cx = c.x() - a.x(), cy = c.y() - a.y(), cz = c.z() - a.z();
  const double dx = d.x() - a.x(), dy = d.y() - a.y(), dz = d.z() - a.z();
  const double by_cz = by * cz, bz_cy = bz * cy;
  const double bz_cx = bz * cx, bx_cz = bx * cz;
  const double bx_cy = bx * cy, by_cx = by * cx;

  const double determinant = (by_cz - bz_cy) * dx + (bz_cx - bx_cz) * dy + (bx_cy - by_cx) * dz;
  const double magnitude = (std::abs(by_cz) + std::abs(bz_cy)) * std::abs(dx) +
                           (std::abs(bz_cx) + std::abs(bx_cz)) * std::abs(dy) +
                           (std::abs(bx_cy) + std::abs(by_cx)) * std::abs(dz);
  const double bound = error_share * magnitude;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  if (magnitude == 0) return 0;  // each product has a factor 0, as in any axis-aligned plane
  return exact_orientation(a, b, c, d);
}

}  // namespace clothsim
